"""How far the head strayed from its planned path, every 2 mm, as in section 3.4 of the paper.

At each planned pose the actual path is cut by the plane through that pose and across the direction
of travel. Where it cuts, the deviation is split into the part across the path and along the skin
(the paper's y-deviation) and the part along the skin's normal (too deep or too shallow).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
_AGAIN = 0.5  # [s] within which the closest of several passings counts
_REACH = 0.02  # [m] the actual path passes a planned pose within this distance, or does not pass it
_LEAD = 0.03  # [m] the head may have travelled more than the planned path between two poses
_AT = 0.001  # [m] a head that begins or ends so near the plane of a pose passes it without cutting it


class PathError(NamedTuple):
    """Deviations at the planned poses, in their order; NaN where the head never passed.

    Attributes:
        across: Along the skin, across the travel [m], shape (M,).
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


def path_error(planned: ArrayLike, times: ArrayLike, actual: ArrayLike) -> PathError:
    """Compare a planned with an actual path.

    Args:
        planned: Poses of the head in the base frame, in order, shape (M, 4, 4). Only their positions and
            approach directions count: their y may lag behind the travel by the turn threshold, and more
            where a path begins.
        times: Time of each actual position [s], increasing, shape (N,).
        actual: Actual positions of the head in the base frame [m], shape (N, 3).
    """
    planned, times = np.asarray(planned, dtype=float), np.asarray(times, dtype=float)
    actual = np.asarray(actual, dtype=float).reshape(-1, 3)
    distance, travelled = _lengths(planned[:, :3, 3]), _lengths(actual)
    across, depth, when = (np.full(len(planned), np.nan) for _ in range(3))
    start, last = 0, 0
    for index, (position, axes) in enumerate(zip(planned[:, :3, 3], travel_axes(planned), strict=True)):
        # a later scan line may come near as well: only what the head did since the last pose can be meant
        ahead = distance[index] - distance[last] + _LEAD
        end = int(np.searchsorted(travelled, travelled[start] + ahead)) + 1 if len(actual) else 0
        passing = _passing((actual[start:end] - position) @ axes, times[start:end])
        if passing is not None:
            across[index], depth[index], when[index] = passing.across, passing.depth, passing.time
            start, last = start + passing.step, index
    return PathError(across, depth, when, distance)


def _lengths(points: Array) -> Array:
    """Length of a polyline up to each of its points [m], shape (N, 3) -> (N,)."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])[: len(points)]


def travel_axes(planned: ArrayLike) -> Array:
    """Axes of travel at each pose of a path, shape (M, 4, 4) -> (M, 3, 3): columns across, along, deep."""
    planned = np.asarray(planned, dtype=float)
    if len(planned) < 2:
        return planned[:, :3, :3]
    along = np.gradient(planned[:, :3, 3], axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    deep = planned[:, :3, 2]
    across = np.cross(along, deep)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    return np.stack([across, along, np.cross(across, along)], axis=-1)


class _Passing(NamedTuple):
    """Where and when a path passes a pose; `step` is the index of the sample before."""

    step: int
    across: float
    depth: float
    time: float


def _passing(seen: Array, times: Array) -> _Passing | None:
    """Find where a path passes from behind a pose to before it, close by; None when it does not.

    Of several passings shortly after one another the closest counts: the way to the first pose may
    cut the plane of that pose as well.

    Args:
        seen: Positions in the axes of the pose [m], shape (N, 3), y along the path.
        times: Of the same [s], shape (N,).
    """
    along = seen[:, 1]
    steps = np.flatnonzero(
        (along[:-1] <= 0.0) & (along[1:] > 0.0) & (np.abs(seen[:-1]).max(axis=1, initial=0.0) < _REACH)
    )
    if not len(steps):
        return _standing(seen, times)
    steps = steps[times[steps] <= times[steps[0]] + _AGAIN]
    share = -along[steps] / (along[steps + 1] - along[steps])
    at = seen[steps] + share[:, None] * (seen[steps + 1] - seen[steps])
    best = int(np.argmin(np.hypot(at[:, 0], at[:, 2])))
    step = int(steps[best])
    time = times[step] + share[best] * (times[step + 1] - times[step])
    return _Passing(step, float(at[best, 0]), float(at[best, 2]), float(time))


def _standing(seen: Array, times: Array) -> _Passing | None:
    """Where the head, without cutting the plane of a pose, begins or ends next to it; None elsewhere."""
    for step in (0, len(times) - 1) if len(times) else ():
        if abs(seen[step, 1]) < _AT and np.abs(seen[step]).max() < _REACH:
            return _Passing(step, float(seen[step, 0]), float(seen[step, 2]), float(times[step]))
    return None
