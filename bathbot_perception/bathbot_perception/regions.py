"""Skin regions: named rectangles in a picture, and the overlap of rectangles."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


class Region(NamedTuple):
    """A rectangle of bare skin.

    `box` is (left, top, right, bottom) [px] in the picture it was found in; (0, 0) is the
    picture's upper left corner, so a box over the whole picture is (0, 0, width, height).
    """

    name: str
    score: float
    box: tuple[float, float, float, float]

    @property
    def centre(self) -> tuple[float, float]:
        """Middle of the box (u, v) [px], the paper's target point (section 3.2)."""
        left, top, right, bottom = self.box
        return (left + right) / 2.0, (top + bottom) / 2.0

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the box [px]."""
        left, top, right, bottom = self.box
        return right - left, bottom - top


def area(boxes: Array) -> Array:
    """Area [px^2], shape (...), of boxes (left, top, right, bottom), shape (..., 4)."""
    extent = np.clip(boxes[..., 2:] - boxes[..., :2], 0.0, None)
    return extent[..., 0] * extent[..., 1]


def overlap(first: Array, second: Array) -> Array:
    """Intersection over union of every box of `first` with every box of `second`.

    Args:
        first: Boxes (left, top, right, bottom) [px], shape (n, 4).
        second: Boxes likewise, shape (m, 4).

    Returns:
        Values in [0, 1], shape (n, m); 0 where both boxes are empty.
    """
    first = np.asarray(first, dtype=np.float64).reshape(-1, 4)
    second = np.asarray(second, dtype=np.float64).reshape(-1, 4)
    corner_low = np.maximum(first[:, None, :2], second[None, :, :2])
    corner_high = np.minimum(first[:, None, 2:], second[None, :, 2:])
    shared = area(np.concatenate([corner_low, corner_high], axis=-1))
    union = area(first)[:, None] + area(second)[None, :] - shared
    return np.divide(shared, union, out=np.zeros_like(shared), where=union > 0.0)
