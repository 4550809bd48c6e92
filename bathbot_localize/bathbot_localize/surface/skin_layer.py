"""Which depth inside a region's box is its skin: one layer, parted from others by gaps in depth.

A box around a limb also holds what lies behind it, and one around a trunk may hold a chin before it.
The skin is the nearest layer that fills a good part of the middle of the box; the middle is where
the paper takes its target from.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_BIN, _GAP = 0.02, 3  # [m] and bins: an empty band of 60 mm parts two layers
_FEW = 0.005  # share of the points below which a bin counts as empty
_MIDDLE = 0.2  # share of the middle that the skin fills at least
_STEP = 0.025  # step of depth between neighbouring pixels, relative, that is an edge


class Layer(NamedTuple):
    """Nearest and farthest depth of a layer [m]."""

    near: float
    far: float

    def holds(self, depth: Array) -> NDArray[np.bool_]:
        """Which of some depths [m], shape (...), belong to it; NaN does not."""
        return (depth >= self.near) & (depth <= self.far)


def depth_layers(depth: Array) -> list[Layer]:
    """Layers of depths [m], shape (...), parted by gaps, the nearest first; stray points make none."""
    values = depth[np.isfinite(depth)]
    if values.size == 0:
        return []
    first = float(values.min())
    counts = np.bincount(((values - first) / _BIN).astype(int))
    filled = np.nonzero(counts > _FEW * values.size)[0]
    parts = np.split(filled, np.nonzero(np.diff(filled) > _GAP)[0] + 1)
    # The thin ends of a layer reach into the bins beside it.
    return [Layer(first + _BIN * (part[0] - 1), first + _BIN * (part[-1] + 2)) for part in parts]


def skin_layer(depth: Array) -> NDArray[np.bool_]:
    """Pixels of a box's depth [m], shape (h, w), that are its skin, shape (h, w); NaN never is."""
    layers = depth_layers(depth)
    if not layers:
        return np.zeros(depth.shape, bool)
    height, width = depth.shape
    middle = depth[height // 4 : height - height // 4, width // 4 : width - width // 4]
    known = max(int(np.isfinite(middle).sum()), 1)
    shares = [np.count_nonzero(layer.holds(middle)) / known for layer in layers]
    chosen = next((i for i, share in enumerate(shares) if share >= _MIDDLE), int(np.argmax(shares)))
    return layers[chosen].holds(depth)


def away_from_edges(depth: Array, stride: float = 1.0) -> NDArray[np.bool_]:
    """Pixels of a depth picture [m], shape (h, w), that no step of depth touches; NaN makes no step.

    Args:
        depth: Shape (h, w).
        stride: Pixels between neighbours; a sloping surface steps more over more of them.
    """
    inside = np.ones(depth.shape, bool)
    for axis in (0, 1):
        with np.errstate(invalid="ignore"):
            step = np.abs(np.diff(depth, axis=axis)) > _STEP * max(stride / 2.0, 1.0) * np.take(
                depth, range(depth.shape[axis] - 1), axis
            )
        padding = [(0, 0), (0, 0)]
        for before in (0, 1):
            padding[axis] = (before, 1 - before)
            inside &= ~np.pad(step, padding)
    return inside
