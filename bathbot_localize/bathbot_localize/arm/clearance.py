"""Room for the scrub head: what rises beside the skin, where the head must not come.

The head is a cylinder behind soft bristles. Where a thigh rises beside a belly, or an arm hangs before
it, a path may be laid on the skin below whose head would push into what stands above. So a place is
clear only if nothing that was seen stands in the column over it.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_STRAY = 3  # fewer points than these in a column are noise at the edges of the picture
_COARSE = 1500  # cells at which a whole surface is judged


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
    places = np.ascontiguousarray(places, dtype=float)
    outward = np.ascontiguousarray(outward, dtype=float)
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    if not len(places) or not len(points):
        return np.ones(len(places), dtype=bool)
    return _counts(points, places, outward, column.radius**2, column.foot, column.top) < _STRAY


def warm_up() -> None:
    """Compile the loop, or load it from the cache of an earlier run."""
    clear(np.zeros((1, 3)), np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), Column(0.03, 0.01))


def has_room(points: Array, outward: Array, column: Column) -> Mask:
    """Cells of an organised surface with an empty column over them, judged on a coarse grid.

    Args:
        points: All that was seen [m], shape (H, W, 3), NaN where nothing was.
        outward: Unit normals, likewise.
        column: What must be empty.

    Returns:
        Mask, shape (H, W); false where nothing was seen.
    """
    known = np.isfinite(points).all(-1) & np.isfinite(outward).all(-1)
    stride = max(int(np.sqrt(known.size / _COARSE)), 1)
    coarse, upright = points[::stride, ::stride], outward[::stride, ::stride]
    rows, columns = np.nonzero(known[::stride, ::stride])
    free = np.zeros(coarse.shape[:2], dtype=bool)
    free[rows, columns] = clear(coarse, coarse[rows, columns], upright[rows, columns], column)
    return known & np.repeat(np.repeat(free, stride, 0), stride, 1)[: known.shape[0], : known.shape[1]]


@njit(cache=True, nogil=True)
def _counts(points, places, outward, radius_squared, foot, top):
    """Number of points, shape (M, 3), in the column over each place, shape (N,); counts to _STRAY only."""
    counts = np.zeros(len(places), np.int64)
    for i in range(len(places)):
        for j in range(len(points)):
            x, y, z = points[j, 0] - places[i, 0], points[j, 1] - places[i, 1], points[j, 2] - places[i, 2]
            height = x * outward[i, 0] + y * outward[i, 1] + z * outward[i, 2]
            if foot < height < top and x * x + y * y + z * z - height * height < radius_squared:
                counts[i] += 1
                if counts[i] == _STRAY:
                    break
    return counts
