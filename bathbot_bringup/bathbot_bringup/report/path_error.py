"""How far the head strayed from its planned path, every 2 mm, as in section 3.4 of the paper.

To each planned pose belongs the closest point of the actual path. The vector from the one to the
other is split into the part along the skin (the paper's y-deviation) and the part along the approach
direction (too deep or too shallow).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
_NEAR = 0.015  # [m] of path before and after a pose in which its closest point is looked for
_REACH = 0.02  # [m] a head farther away than this does not pass a pose
_AT = 0.001  # [m] a path that begins or ends so near a pose passes it


class PathError(NamedTuple):
    """Deviations at the planned poses, in their order; NaN where the head never passed.

    Attributes:
        across: Along the skin [m], positive towards the head's side (travel x approach), shape (M,).
        depth: Along the approach direction, positive deeper [m], shape (M,).
        time: When the head passed [s], shape (M,).
        distance: Length of the planned path up to each pose [m], shape (M,).
    """

    across: Array
    depth: Array
    time: Array
    distance: Array

    @property
    def passed(self) -> NDArray[np.bool_]:
        """Which planned poses the head passed, shape (M,)."""
        return np.isfinite(self.time)


def path_error(planned: ArrayLike, times: ArrayLike, actual: ArrayLike, along: ArrayLike) -> PathError:
    """Compare a planned with an actual path.

    Args:
        planned: Poses of the head in the base frame, in order, shape (M, 4, 4); z into the skin.
        times: Time of each actual position [s], increasing, shape (N,).
        actual: Actual positions of the head in the base frame [m], shape (N, 3).
        along: How far the head had come along the path then, by the driver's count [m], shape (N,). A path
            may come near itself or cross itself: the count tells which of its lines is meant.
    """
    planned, times = np.asarray(planned, dtype=float), np.asarray(times, dtype=float)
    actual, along = np.asarray(actual, dtype=float).reshape(-1, 3), np.asarray(along, dtype=float)
    across, depth, when = (np.full(len(planned), np.nan) for _ in range(3))
    distance, sides = _lengths(planned[:, :3, 3]), _sides(planned)
    reached = distance <= along.max(initial=-np.inf) + _AT
    for index in np.flatnonzero(reached):
        near = np.flatnonzero(np.abs(along - distance[index]) <= _NEAR)
        closest = _closest(actual[near] - planned[index, :3, 3], times[near])
        if closest is None:
            continue
        inward = planned[index, :3, 2]
        depth[index], when[index] = float(closest.offset @ inward), closest.time
        beside = closest.offset - depth[index] * inward
        across[index] = np.copysign(np.linalg.norm(beside), beside @ sides[index])
    return PathError(across, depth, when, distance)


class _Closest(NamedTuple):
    """The point of a path that is closest to the origin, and when it was passed [s]."""

    offset: Array
    time: float


def _closest(points: Array, times: Array) -> _Closest | None:
    """Find the point of a polyline, shape (N, 3), closest to the origin; None when it is too far away."""
    if not len(points):
        return None
    steps = np.diff(points, axis=0)
    squares = np.maximum(np.sum(steps**2, axis=1), 1e-18)
    share = np.clip(-np.sum(points[:-1] * steps, axis=1) / squares, 0.0, 1.0)
    candidates = np.concatenate([points[:-1] + share[:, None] * steps, points[-1:]])
    when = np.concatenate([times[:-1] + share * np.diff(times), times[-1:]])
    best = int(np.argmin(np.linalg.norm(candidates, axis=1)))
    return (
        _Closest(candidates[best], float(when[best])) if np.linalg.norm(candidates[best]) < _REACH else None
    )


def _lengths(points: Array) -> Array:
    """Length of a polyline up to each of its points [m], shape (N, 3) -> (N,)."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])[: len(points)]


def _sides(planned: Array) -> Array:
    """Directions across the travel, along the skin, at each pose: shape (M, 4, 4) -> (M, 3)."""
    if len(planned) < 2:
        return planned[:, :3, 0]
    return np.cross(np.gradient(planned[:, :3, 3], axis=0), planned[:, :3, 2])
