"""Which of the joint solutions of a head pose to prefer: those with room for a path around the pose."""

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.errors import UnreachableError
from bathbot_scrub.rm65.inverse_kinematics import solve_head, unwind, within_limits
from bathbot_scrub.rm65.kinematics import Kinematics
from bathbot_scrub.rm65.limits import JointLimits
from bathbot_scrub.rm65.reach_reason import why_unreachable

Array = NDArray[np.float64]
_ROOM = 0.7  # [rad] wanted about a posture that paths begin from
_ROOM_WEIGHT = 10.0  # its worth against travel


def postures(kinematics: Kinematics, T_base_head: Array, start: Array, limits: JointLimits) -> Array:
    """Joints [rad], shape (N, 6), that hold the head at a pose, (4, 4), the best to go to from `start` first.

    Raises:
        UnreachableError: When there are none; with the reason.
    """
    solutions = within_limits(unwind(solve_head(kinematics, T_base_head, limits), start), limits)
    cost = np.abs(solutions - start).sum(-1) + _ROOM_WEIGHT * (_ROOM - _room(solutions, limits))
    order = np.argsort(cost)[: np.isfinite(cost).sum()]
    if not len(order):
        place = "({:.3f}, {:.3f}, {:.3f}) m".format(*T_base_head[:3, 3])
        why = why_unreachable(kinematics, T_base_head, limits)
        raise UnreachableError(f"no joint solution for the head at {place}: {why}")
    return solutions[order]


def _room(joints: Array, limits: JointLimits) -> Array:
    """How far joints [rad], shape (..., 6), may turn to a limit or a flip of the wrist, 0.._ROOM."""
    room = np.minimum(limits.upper - joints, joints - limits.lower).min(-1)
    return np.clip(np.minimum(room, np.abs(joints[..., 4])), 0.0, _ROOM)
