"""What every method of the evaluation gives, and how it says that there is no depth."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Depth = NDArray[np.float32]


class Fitted(Protocol):
    """A fitted correction."""

    @property
    def T_colour_depth(self) -> NDArray[np.float64]:
        """Maps points of the depth frame to the colour frame, shape (4, 4)."""
        ...

    def apply(self, depth: Depth) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        ...


def positive(depth: Depth) -> Depth:
    """Depth as float32, NaN where it is not positive."""
    return np.where(depth > 0.0, depth, np.nan).astype(np.float32)
