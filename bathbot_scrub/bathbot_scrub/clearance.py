"""Room for the scrub head: what rises beside the skin, where the head must not come.

The head is a cylinder behind soft bristles. Where a thigh rises beside a belly, or an arm hangs before
it, a path may be laid on the skin below whose head would push into what stands above. So a place is
clear only if nothing that was seen stands in the column over it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_STRAY = 3  # fewer points than these in a column are noise at the edges of the picture
_BATCH = 200  # places judged at once: bounds the memory


class Column(NamedTuple):
    """The space over a place that must be empty, along the outward normal.

    Attributes:
        radius: [m].
        foot: Height over the place at which it begins [m]; less is relief that the bristles take up.
        top: Height at which it ends [m].
    """

    radius: float
    foot: float
    top: float = 0.20


def clear(points: ArrayLike, places: ArrayLike, outward: ArrayLike, column: Column) -> Mask:
    """Which places have an empty column.

    Args:
        points: All that was seen [m], shape (..., 3), NaN where nothing was.
        places: On the skin [m], same frame, shape (N, 3).
        outward: Unit normals there, shape (N, 3).
        column: What must be empty.

    Returns:
        Mask, shape (N,).
    """
    places, outward = np.asarray(places, dtype=float), np.asarray(outward, dtype=float)
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    if not len(places) or not len(points):
        return np.ones(len(places), dtype=bool)
    reach = np.hypot(column.radius, column.top)
    near = np.all((points > places.min(0) - reach) & (points < places.max(0) + reach), axis=1)
    points, batches = points[near], range(0, len(places), _BATCH)
    counts = [_inside(points, places[i : i + _BATCH], outward[i : i + _BATCH], column) for i in batches]
    return np.concatenate(counts) < _STRAY


def _inside(points: Array, places: Array, outward: Array, column: Column) -> NDArray[np.int_]:
    """Number of points (M, 3) in the column over each place (N, 3), shape (N,)."""
    middle = places.mean(0)  # small numbers keep their digits in the difference of squares below
    points, places = points - middle, places - middle
    height = points @ outward.T - np.sum(places * outward, axis=1)
    squared = (
        np.sum(points**2, axis=1)[:, None] - 2.0 * points @ places.T + np.sum(places**2, axis=1) - height**2
    )
    return np.sum((height > column.foot) & (height < column.top) & (squared < column.radius**2), axis=0)
