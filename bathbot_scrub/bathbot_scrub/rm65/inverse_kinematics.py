"""Closed-form inverse kinematics of the RM65, all eight branches, over whole paths.

Joints 4, 5 and 6 meet in the wrist centre and joints 2 and 3 are parallel, so the first three joints
follow from the wrist centre (shoulder front or back, elbow either way) and the last three from the
rotation that is left (wrist either way): Rz(q4) Ry(q5) Rz(q6).
"""

import numpy as np
from bathbot_depthcorr.rigid import inverse
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.errors import InvalidPoseError, UnreachableError
from bathbot_scrub.rm65.kinematics import BASE_HEIGHT, FOREARM, T_HEAD_FLANGE, UPPER_ARM, Kinematics
from bathbot_scrub.rm65.limits import RM65_LIMITS, JointLimits

Array = NDArray[np.float64]
_REACH_SLACK = 1e-9  # of the elbow's cosine: a straight arm is reachable up to rounding
_SINGULAR = 1e-9  # sine of q5 below which q4 and q6 turn about one axis


def all_branches(kinematics: Kinematics, T_base_flange: ArrayLike) -> Array:
    """Solve for joint angles on all eight branches, without regard to limits.

    Args:
        kinematics: The arm.
        T_base_flange: Poses of the flange, shape (..., 4, 4).

    Returns:
        Angles [rad] in (-pi, pi], shape (..., 8, 6), NaN where out of reach. The branch index is
        4 * shoulder + 2 * elbow + wrist and keeps its meaning along a path.
    """
    poses = np.asarray(T_base_flange, dtype=float)
    wrist = poses[..., :3, 3] - kinematics.flange_offset * poses[..., :3, 2]
    rho = np.hypot(wrist[..., 0], wrist[..., 1])
    height = wrist[..., 2] - BASE_HEIGHT
    cosine = (rho**2 + height**2 - UPPER_ARM**2 - FOREARM**2) / (2 * UPPER_ARM * FOREARM)
    cosine = np.where(np.abs(cosine) <= 1.0 + _REACH_SLACK, np.clip(cosine, -1.0, 1.0), np.nan)
    elbow = np.arccos(cosine)
    solutions = np.empty((*poses.shape[:-2], 8, 6))
    for shoulder, forward in enumerate((1.0, -1.0)):
        # positive q2 and q3 lean the arm towards -x of frame 1, hence the signs
        pan = np.arctan2(forward * wrist[..., 1], forward * wrist[..., 0])
        for bend, sign in enumerate((-1.0, 1.0)):
            q3 = sign * elbow
            q2 = np.arctan2(-forward * rho, height) - np.arctan2(
                FOREARM * np.sin(q3), UPPER_ARM + FOREARM * np.cos(q3)
            )
            _solve_wrist(poses, pan, q2, q3, solutions[..., 4 * shoulder + 2 * bend :, :])
    return wrap(solutions)


def _solve_wrist(poses: Array, q1: Array, q2: Array, q3: Array, out: Array) -> None:
    """Fill the two wrist branches `out[..., :2, :]` for given q1, q2, q3 [rad], shape (...)."""
    c1, s1, c23, s23 = np.cos(q1), np.sin(q1), np.cos(q2 + q3), np.sin(q2 + q3)
    zero = np.zeros_like(c1)
    # rows: axes x, y, z of frame 4 at q4 = 0, in the base frame; z is the forearm
    rows = np.stack(
        [
            np.stack([-c23 * c1, -c23 * s1, -s23], -1),
            np.stack([s1, -c1, zero], -1),
            np.stack([-s23 * c1, -s23 * s1, c23], -1),
        ],
        -2,
    )
    turn = rows @ poses[..., :3, :3]
    sine = np.hypot(turn[..., 0, 2], turn[..., 1, 2])
    singular = sine < _SINGULAR
    for wrist, sign in enumerate((1.0, -1.0)):
        q4 = np.where(singular, 0.0, np.arctan2(sign * turn[..., 1, 2], sign * turn[..., 0, 2]))
        q6 = np.arctan2(sign * turn[..., 2, 1], -sign * turn[..., 2, 0])
        straight = np.arctan2(turn[..., 1, 0], turn[..., 1, 1])
        out[..., wrist, 0], out[..., wrist, 1], out[..., wrist, 2] = q1, q2, q3
        out[..., wrist, 3] = q4
        out[..., wrist, 4] = np.arctan2(sign * sine, turn[..., 2, 2])
        out[..., wrist, 5] = np.where(singular, straight, q6)


def wrap(angles: ArrayLike) -> Array:
    """Bring angles [rad] into (-pi, pi]."""
    return -np.remainder(-np.asarray(angles, dtype=float) + np.pi, 2 * np.pi) + np.pi


def check_poses(T: ArrayLike) -> Array:
    """Refuse transforms, shape (..., 4, 4), that are not finite or not rigid to 1e-6.

    Raises:
        InvalidPoseError: Names the first bad pose.
    """
    poses = np.asarray(T, dtype=float)
    if poses.shape[-2:] != (4, 4):
        raise InvalidPoseError(f"a pose must be a 4x4 transform, got shape {poses.shape}")
    rotation = np.nan_to_num(poses[..., :3, :3])
    gram = rotation @ np.swapaxes(rotation, -1, -2)
    good = np.isfinite(poses).all((-2, -1))
    good &= (np.abs(gram - np.eye(3)).max((-2, -1)) < 1e-6) & (np.linalg.det(rotation) > 0.0)
    if not np.all(good):
        index = int(np.flatnonzero(~np.ravel(good))[0])
        raise InvalidPoseError(
            f"pose {index} is not finite or its rotation is not orthonormal; send unit quaternions"
        )
    return poses


def within_limits(solutions: ArrayLike, limits: JointLimits = RM65_LIMITS) -> Array:
    """Replace solutions [rad], shape (..., 6), outside the limits by NaN."""
    solutions = np.asarray(solutions, dtype=float)
    return np.where(limits.contain(solutions)[..., None], solutions, np.nan)


def unwind(solutions: ArrayLike, seed: ArrayLike, limits: JointLimits = RM65_LIMITS) -> Array:
    """Add full turns so that each angle [rad], shape (..., 6), is nearest to `seed` inside the limits."""
    solutions, seed = np.asarray(solutions, dtype=float), np.asarray(seed, dtype=float)
    near = solutions + 2 * np.pi * np.round((seed - solutions) / (2 * np.pi))
    near = np.where(near > limits.upper, near - 2 * np.pi, near)
    return np.where(near < limits.lower, near + 2 * np.pi, near)


def nearest(solutions: ArrayLike, seed: ArrayLike, limits: JointLimits = RM65_LIMITS) -> Array:
    """Choose the solution whose largest joint travel from `seed` is least.

    Args:
        solutions: Candidates [rad], shape (8, 6), NaN where there is none.
        seed: Joint angles [rad], shape (6,).
        limits: Candidates outside are not considered.

    Returns:
        Joint angles [rad], shape (6,).

    Raises:
        UnreachableError: When no candidate lies inside the limits.
    """
    candidates = within_limits(unwind(solutions, seed, limits), limits)
    travel = np.abs(candidates - np.asarray(seed)).max(-1)
    if np.all(np.isnan(travel)):
        raise UnreachableError(
            "no joint solution inside the limits; choose a nearer target or another direction"
        )
    return candidates[int(np.nanargmin(travel))]


def solve_head(kinematics: Kinematics, T_base_head: ArrayLike, limits: JointLimits = RM65_LIMITS) -> Array:
    """Joint angles [rad], shape (..., 8, 6), that hold the head at poses (..., 4, 4); NaN where none."""
    return within_limits(all_branches(kinematics, check_poses(T_base_head) @ T_HEAD_FLANGE), limits)


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
