"""Closed-form inverse kinematics of the RM65, all eight branches, over whole paths.

Joints 4, 5 and 6 meet in the wrist centre and joints 2 and 3 are parallel, so the first three joints
follow from the wrist centre (shoulder front or back, elbow either way) and the last three from the
rotation that is left (wrist either way): Rz(q4) Ry(q5) Rz(q6). The formulas are in `branch_kernel`. Where
there is no solution, `why_unreachable` says what keeps the head from the pose.
"""

from dataclasses import replace

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.errors import InvalidPoseError
from bathbot_scrub.arm.joint_limits import JointLimits
from bathbot_scrub.rm65.arm.branch_kernel import fill_branches, first_flawed
from bathbot_scrub.rm65.arm.kinematics import BASE_HEIGHT, FOREARM, UPPER_ARM, Kinematics
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS

Array = NDArray[np.float64]
# Limits, too, so that the kernel is the one compiled for limits: none may be compiled once the arm moves.
_ANY_ANGLE = replace(RM65_LIMITS, lower=np.full(6, -np.inf), upper=np.full(6, np.inf))
_LONGEST, _SHORTEST = UPPER_ARM + FOREARM, UPPER_ARM - FOREARM  # [m] from shoulder to wrist


def all_branches(kinematics: Kinematics, T_base_flange: ArrayLike) -> Array:
    """Solve for joint angles on all eight branches, without regard to limits.

    Args:
        kinematics: The arm.
        T_base_flange: Poses of the flange, shape (..., 4, 4).

    Returns:
        Angles [rad] in (-pi, pi], shape (..., 8, 6), NaN where out of reach. The branch index is
        4 * shoulder + 2 * elbow + wrist and keeps its meaning along a path.
    """
    return _branches(kinematics, np.asarray(T_base_flange, dtype=float), _ANY_ANGLE.lower, _ANY_ANGLE.upper)


def _branches(kinematics: Kinematics, T_base_flange: Array, lower: Array, upper: Array) -> Array:
    out = np.empty((*T_base_flange.shape[:-2], 8, 6))
    fill_branches(
        np.ascontiguousarray(T_base_flange).reshape(-1, 4, 4),
        BASE_HEIGHT, UPPER_ARM, FOREARM, kinematics.flange_offset,
        np.ascontiguousarray(lower), np.ascontiguousarray(upper), out.reshape(-1, 8, 6),
    )  # fmt: skip
    return out


def check_poses(T: ArrayLike) -> Array:
    """Refuse transforms, shape (..., 4, 4), that are not finite or not rigid to 1e-6.

    Raises:
        InvalidPoseError: Names the first bad pose.
    """
    poses = np.asarray(T, dtype=float)
    if poses.shape[-2:] != (4, 4):
        raise InvalidPoseError(f"a pose must be a 4x4 transform, got shape {poses.shape}")
    index = first_flawed(np.ascontiguousarray(poses).reshape(-1, 4, 4))
    if index >= 0:
        raise InvalidPoseError(
            f"pose {index} is not finite or its rotation is not orthonormal; send unit quaternions"
        )
    return poses


def solve_head(kinematics: Kinematics, T_base_head: ArrayLike, limits: JointLimits = RM65_LIMITS) -> Array:
    """Joint angles [rad], shape (..., 8, 6), that hold the head at poses (..., 4, 4); NaN where none."""
    flanges = check_poses(T_base_head) @ kinematics.tool.T_head_flange
    return _branches(kinematics, flanges, limits.lower, limits.upper)


def distance_to_singularity(kinematics: Kinematics, joints: ArrayLike) -> Array:
    """Least distance of joints [rad], shape (..., 6), to a singular posture, shape (...).

    The least of |sin q5| (wrist), |sin q3| (elbow) and the wrist centre's distance to the axis of
    joint 1 over the forearm's length (shoulder).
    """
    joints = np.asarray(joints, dtype=float)
    wrist = (
        inverse(kinematics.link_frames(joints)[..., 1, :, :]) @ kinematics.link_frames(joints)[..., 4, :, :]
    )
    shoulder = np.hypot(wrist[..., 0, 3], wrist[..., 1, 3]) / FOREARM
    return np.minimum.reduce([np.abs(np.sin(joints[..., 4])), np.abs(np.sin(joints[..., 2])), shoulder])


def why_unreachable(
    kinematics: Kinematics,
    T_base_head: ArrayLike,
    limits: JointLimits = RM65_LIMITS,
    branch: int | None = None,
) -> str:
    """Say what keeps the head from a pose, (4, 4), on a branch or on all; empty when nothing does."""
    flange = np.asarray(T_base_head, dtype=float) @ kinematics.tool.T_head_flange
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
