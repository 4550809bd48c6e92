"""How far the head strayed from its planned path, every 2 mm, as in section 3.4 of the paper.

At each planned pose the actual path is cut by the plane through that pose and across the direction
of travel. Where it cuts, the deviation is split into the part across the path and along the skin
(the paper's y-deviation) and the part along the skin's normal (too deep or too shallow).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
_REACH = 0.02  # [m] the actual path passes a planned pose within this distance, or does not pass it


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
        planned: Poses of the head in the base frame, in order, shape (M, 4, 4); y lies along the path.
        times: Time of each actual position [s], increasing, shape (N,).
        actual: Actual positions of the head in the base frame [m], shape (N, 3).
    """
    planned, times = np.asarray(planned, dtype=float), np.asarray(times, dtype=float)
    actual = np.asarray(actual, dtype=float).reshape(-1, 3)
    count = len(planned)
    across, depth, when = (np.full(count, np.nan) for _ in range(3))
    start = 0
    for index, pose in enumerate(planned):
        seen = (actual[start:] - pose[:3, 3]) @ pose[:3, :3]  # in the head's axes: across, along, deep
        crossing = _first_crossing(seen)
        if crossing is None:
            continue
        step, share = crossing
        at = seen[step] + share * (seen[step + 1] - seen[step])
        across[index], depth[index] = at[0], at[2]
        when[index] = times[start + step] + share * (times[start + step + 1] - times[start + step])
        start += step
    steps = np.linalg.norm(np.diff(planned[:, :3, 3], axis=0), axis=1) if count else np.zeros(0)
    return PathError(across, depth, when, np.concatenate([[0.0], np.cumsum(steps)])[:count])


def _first_crossing(seen: Array) -> tuple[int, float] | None:
    """Find where a path first passes from behind a pose to before it, close by.

    Args:
        seen: Positions in the axes of the pose [m], shape (N, 3), y along the path.

    Returns:
        Index of the step and the share of it up to the crossing; None when there is no crossing.
    """
    along = seen[:, 1]
    passing = (along[:-1] <= 0.0) & (along[1:] > 0.0) & (np.abs(seen[:-1]).max(axis=1) < _REACH)
    if not passing.any():
        return None
    step = int(np.argmax(passing))
    return step, float(-along[step] / (along[step + 1] - along[step]))
