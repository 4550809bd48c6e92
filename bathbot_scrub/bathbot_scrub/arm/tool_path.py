"""From head poses to joints along a path: dense samples, one branch, no jumps."""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.branches import nearest, wrap
from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.joint_limits import JointLimits

Array = NDArray[np.float64]
SAMPLE_TURN = 0.01  # [rad] between joint samples, at most
SAMPLE_STEP = 0.001  # [m] between joint samples of a tool path
LARGEST_STEP = 0.2  # [rad] between joint samples; more is a flip of the wrist


def step_lengths(poses: ArrayLike) -> Array:
    """Lengths of the steps between head poses, shape (N, 4, 4) -> (N - 1,) [m].

    A turn on the spot counts as 0.1 m per rad, so that it takes its time too.
    """
    poses = np.asarray(poses, dtype=float)
    moved = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    turned = _turns(Rotation.from_matrix(poses[:, :3, :3]))
    return np.maximum(moved, 0.1 * np.where(moved > 1e-5, 0.0, turned))


def _turns(rotations: Rotation) -> Array:
    return (rotations[:-1].inv() * rotations[1:]).magnitude()


def densify(poses: ArrayLike, step: float = SAMPLE_STEP) -> tuple[Array, Array]:
    """Straight lines and slerp between head poses, shape (N, 4, 4), sampled every `step` [m] or finer.

    Returns:
        Lengths s [m], as of `step_lengths`, shape (M,), from 0, and poses, shape (M, 4, 4).
    """
    poses = np.asarray(poses, dtype=float)
    rotations = Rotation.from_matrix(poses[:, :3, :3])
    turned = _turns(rotations)
    lengths = step_lengths(poses)
    counts = np.maximum(np.ceil(np.maximum(lengths / step, turned / SAMPLE_TURN)), 1).astype(int)
    keep = np.concatenate([[True], lengths > 1e-7])  # equal poses add nothing
    knots = np.concatenate([[0.0], np.cumsum(lengths)])
    pieces = [
        np.linspace(a, b, n + 1)[1:]
        for a, b, n in zip(knots, knots[1:], counts, strict=False)
        if b - a > 1e-7
    ]
    if not pieces:
        return np.zeros(1), poses[:1]
    at = np.concatenate([[0.0], *pieces])
    dense = np.tile(np.eye(4), (len(at), 1, 1))
    dense[:, :3, :3] = Slerp(knots[keep], rotations[keep])(at).as_matrix()
    for axis in range(3):
        dense[:, axis, 3] = np.interp(at, knots[keep], poses[keep, axis, 3])
    return at, dense


def solve_path(arm: Arm, poses: ArrayLike, seed: ArrayLike, limits: JointLimits | None = None) -> Array:
    """Joint angles along a path of head poses, on one branch, without jumps.

    Args:
        arm: Whose path it is.
        poses: T_base_head, shape (N, 4, 4), closely spaced.
        seed: Joints [rad], shape (J,), from which the path begins; decides the branch.
        limits: Of the joints; the arm's own if left out.

    Returns:
        Joints [rad], shape (N, J).

    Raises:
        UnreachableError: Out of reach, outside the limits, or through a singularity where the wrist
            would flip.
    """
    poses = np.asarray(poses, dtype=float)
    limits = limits or arm.limits
    solutions = arm.solve_head(poses, limits)
    if np.isnan(solutions[0]).any(-1).all():
        raise UnreachableError(f"pose 0 of the path is out of reach: {arm.why_unreachable(poses[0], limits)}")
    start = nearest(solutions[0], seed, limits)
    branch = int(np.nanargmin(np.abs(wrap(solutions[0] - start)).max(-1)))
    chosen = solutions[:, branch]
    lost = np.isnan(chosen).any(-1)
    if lost.any():
        index = int(np.argmax(lost))
        _continuous(chosen[:index], start, limits)  # a joint may meet its limit before that
        why = arm.why_unreachable(poses[index], limits, branch)
        raise UnreachableError(f"pose {index} of {len(lost)} of the path is out of reach: {why}", index)
    return _continuous(chosen, start, limits)


def _continuous(joints: Array, start: Array, limits: JointLimits) -> Array:
    """Unwrap whole turns along the path and refuse what jumps or leaves the limits."""
    joints = np.unwrap(joints, axis=0)
    joints += start - joints[0]
    steps = np.abs(np.diff(joints, axis=0, prepend=joints[:1]))
    flips, outside = steps.max(-1) > LARGEST_STEP, ~limits.contain(joints)
    if not (flips | outside).any():
        return joints
    index = int(np.argmax(flips | outside))  # whichever comes first: what is behind it was never asked for
    if flips[index]:
        joint = int(np.argmax(steps[index]))
        raise UnreachableError(
            f"pose {index} of {len(joints)} of the path turns joint {joint + 1} by "
            f"{steps[index, joint]:.2f} rad at once (singular posture); choose another direction of travel",
            index,
        )
    beyond = np.maximum(joints[index] - limits.upper, limits.lower - joints[index])
    joint = int(np.argmax(beyond))
    angle = joints[index, joint]
    limit = (limits.upper if angle > 0.0 else limits.lower)[joint]
    raise UnreachableError(
        f"pose {index} of {len(joints)} of the path needs a joint beyond its limits: "
        f"joint {joint + 1} at {np.degrees(angle):.1f} deg, its limit is {np.degrees(limit):.1f}",
        index,
    )


def retreated(T_base_head: Array, distance: float) -> Array:
    """The head pose `distance` [m] back along its z axis, (4, 4)."""
    T = np.array(T_base_head, dtype=float)
    T[:3, 3] -= distance * T[:3, 2]
    return T
