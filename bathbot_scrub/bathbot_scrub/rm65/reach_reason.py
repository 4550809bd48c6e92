"""Why the arm cannot hold a pose: the limit of length or of a joint that is nearest to being met."""

import numpy as np
from numpy.typing import ArrayLike

from bathbot_scrub.rm65.inverse_kinematics import all_branches
from bathbot_scrub.rm65.kinematics import BASE_HEIGHT, FOREARM, T_HEAD_FLANGE, UPPER_ARM, Kinematics
from bathbot_scrub.rm65.limits import RM65_LIMITS, JointLimits

_LONGEST, _SHORTEST = UPPER_ARM + FOREARM, UPPER_ARM - FOREARM


def why_unreachable(
    kinematics: Kinematics,
    T_base_head: ArrayLike,
    limits: JointLimits = RM65_LIMITS,
    branch: int | None = None,
) -> str:
    """Say what keeps the head from a pose, (4, 4), on a branch or on all; empty when nothing does."""
    flange = np.asarray(T_base_head, dtype=float) @ T_HEAD_FLANGE
    wrist = flange[:3, 3] - kinematics.flange_offset * flange[:3, 2] - (0.0, 0.0, BASE_HEIGHT)
    distance = float(np.linalg.norm(wrist))
    solutions = np.atleast_2d(all_branches(kinematics, flange)[slice(None) if branch is None else branch])
    if np.isnan(solutions).all():
        away, limit = ("more", _LONGEST) if distance > _LONGEST else ("less", _SHORTEST)
        return (
            f"the wrist would be {distance:.3f} m from the shoulder, {away} than {limit:.3f} m; "
            f"bring the target {'nearer' if away == 'more' else 'farther away'}"
        )
    if limits.contain(solutions).any():
        return ""
    beyond = np.maximum(solutions - limits.upper, limits.lower - solutions)
    nearest = int(np.argmin(beyond.max(-1)))
    joint = int(np.argmax(beyond[nearest]))
    angle = float(solutions[nearest, joint])
    limit = float((limits.upper if angle > 0.0 else limits.lower)[joint])
    return (
        f"joint {joint + 1} would be at {np.degrees(angle):.1f} deg, its limit is {np.degrees(limit):.1f}; "
        "choose a target or a turn of the head nearer to the middle"
    )
