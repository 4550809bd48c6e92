"""Normals of a surface given as scan lines: Fig. 6 and Eqs. (11)-(13).

Each point P(i, j) shares a triangle with every two neighbours P(i, j+1), P(i-1, j), P(i, j-1),
P(i+1, j) that follow each other around it. The paper lists three of these four triangles; we use all
four. Its normal is the mean of theirs weighted with their areas: the plain sum of the cross products
of Eq. (11), whose lengths are twice the areas. Border points have two triangles, corners one.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def triangle_normals(points: ArrayLike, outside: ArrayLike) -> Array:
    """Unit normals of points on neighbouring scan lines.

    Args:
        points: P(i, j) [m], shape (lines, points, 3), point j of each line next to point j of its
            neighbours; NaN where there is none.
        outside: Direction that leaves the body, shape (3,), or one for each point, such as
            `viewpoint - points`.

    Returns:
        Normals on the side of `outside`, shape (lines, points, 3); NaN where no triangle is complete.
    """
    points = np.asarray(points, dtype=float)
    padded = np.pad(points, ((1, 1), (1, 1), (0, 0)), constant_values=np.nan)
    centre = padded[1:-1, 1:-1]
    around = [padded[1:-1, 2:], padded[:-2, 1:-1], padded[1:-1, :-2], padded[2:, 1:-1]]
    spokes = [neighbour - centre for neighbour in around]
    total = np.zeros_like(points)
    for one, following in zip(spokes, spokes[1:] + spokes[:1], strict=True):
        twice_area = np.cross(one, following)  # Eq. (11)
        total += np.where(np.isfinite(twice_area), twice_area, 0.0)
    length = np.linalg.norm(total, axis=-1, keepdims=True)  # Eq. (12)
    normals = np.divide(total, length, out=np.full_like(total, np.nan), where=length > 0.0)  # Eq. (13)
    towards = np.sum(normals * np.asarray(outside, dtype=float), axis=-1, keepdims=True)
    return np.where(towards < 0.0, -normals, normals)
