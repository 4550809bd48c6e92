"""The sub-pixel ripple of stereo matching: an error that repeats with every pixel of disparity.

A polynomial of depth cannot follow it (at 0.75 m a period is 9 mm long); two sines of disparity do.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

ORDERS = (1, 2)
TERMS = 2 * len(ORDERS)
_LARGEST_BEND = 0.5  # of the slope of d'(d): keeps the correction monotone


def ripple_terms(disparity: ArrayLike) -> NDArray[np.float64]:
    """Sines and cosines of the ripple, shape (..., 4), at disparities [px], shape (...)."""
    phase = 2.0 * np.pi * np.asarray(disparity)
    return np.stack([wave(order * phase) for order in ORDERS for wave in (np.sin, np.cos)], axis=-1)


def tame(ripple: ArrayLike) -> NDArray[np.float64]:
    """Shrink ripple amplitudes [px], shape (4,), where they would make d'(d) fall."""
    ripple = np.asarray(ripple, dtype=float)
    bend = 2.0 * np.pi * float(np.sum(np.repeat(ORDERS, 2) * np.abs(ripple)))
    return ripple * min(1.0, _LARGEST_BEND / max(bend, 1e-12))
