"""A geometric path in joint space: dense samples over a length, without time.

The length s is what the motion is about: metres of tool path, or radians of the fastest joint. Along a
tool path a joint that turns far counts as length too, so that a speed and an acceleration of s bound
those of every joint. Time comes from `PathRunner`, which may stop anywhere and go on.
"""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

from bathbot_scrub.rm65.errors import UnreachableError
from bathbot_scrub.rm65.inverse_kinematics import nearest, solve_head, wrap
from bathbot_scrub.rm65.kinematics import Kinematics
from bathbot_scrub.rm65.limits import RM65_LIMITS, JointLimits

Array = NDArray[np.float64]
SAMPLE_STEP = 0.001  # [m] between joint samples of a tool path
SAMPLE_TURN = 0.01  # [rad] between joint samples, at most
LEVER = 0.1  # [m/rad] by which the travel of a joint counts as length of a tool path
LARGEST_STEP = 0.2  # [rad] between joint samples; more is a flip of the wrist


@dataclass(frozen=True, slots=True)
class JointPath:
    """Joint angles [rad], shape (N, 6), at lengths s, shape (N,), rising from 0."""

    lengths: Array
    joints: Array
    speed_limit: Array = field(repr=False)  # (N,) largest ds/dt the joints allow, here and to stop in time
    slopes: Array = field(init=False, repr=False)  # (N, 6) dq/ds

    def __post_init__(self) -> None:
        """Find the slopes at the samples."""
        object.__setattr__(self, "slopes", np.gradient(self.joints, self.lengths, axis=0))

    @property
    def end(self) -> float:
        """Length of the whole path."""
        return float(self.lengths[-1])

    def at(self, length: float) -> Array:
        """Joint angles [rad], shape (6,), at a length, held at both ends.

        Cubic between samples: a straight line would jolt every joint at every sample.
        """
        lengths = self.lengths
        index = min(max(int(np.searchsorted(lengths, length)), 1), len(lengths) - 1)
        before, after = lengths[index - 1], lengths[index]
        step = after - before
        t = min(max((length - before) / step, 0.0), 1.0)
        rise = self.joints[index] - self.joints[index - 1]
        early, late = step * self.slopes[index - 1] - rise, rise - step * self.slopes[index]
        return self.joints[index - 1] + t * rise + t * (1.0 - t) * ((1.0 - t) * early + t * late)

    def back_from(self, length: float, distance: float) -> "JointPath":
        """The way back from a length, `distance` long or to the beginning."""
        begin = max(length - distance, 0.0)
        inner = self.lengths[(self.lengths > begin + 1e-9) & (self.lengths < length - 1e-9)]
        at = np.concatenate([[max(length, begin + 1e-6)], inner[::-1], [begin]])
        joints = np.stack([self.at(s) for s in at])
        return JointPath(at[0] - at, joints, np.full(len(at), np.inf))

    def speed_at(self, length: float, ahead: float = 0.0) -> float:
        """Largest ds/dt allowed from a length to one farther `ahead`."""
        last = len(self.lengths) - 1
        begin, end = np.searchsorted(self.lengths, (length, length + ahead))
        return float(self.speed_limit[min(begin, last) : min(end, last) + 1].min())


def timed_path(
    lengths: Array,
    joints: Array,
    deceleration: float,
    limits: JointLimits,
    share: float,
    cap: ArrayLike = np.inf,
) -> JointPath:
    """Add to a path the speed that joint speeds, joint accelerations and braking distances allow.

    Args:
        lengths: s of the samples, shape (N,), strictly rising.
        joints: [rad], shape (N, 6).
        deceleration: Of s, with which slower parts ahead are met.
        limits: Of the joints.
        share: Of the joints' speed and acceleration that may be used, 0..1.
        cap: Largest ds/dt wanted, at each sample or one for all.
    """
    step = np.diff(lengths)[:, None]
    slope = np.diff(joints, axis=0) / step
    speed = (share * limits.speed / np.maximum(np.abs(slope), 1e-9)).min(-1)
    squared = np.append(speed, speed[-1]) ** 2
    squared[1:-1] = np.minimum(squared[1:-1], speed[:-1] ** 2)
    if len(lengths) > 2:
        bend = np.abs(np.diff(slope, axis=0)) / (0.5 * (step[1:] + step[:-1]))
        allowed = (share * limits.acceleration / np.maximum(bend, 1e-9)).min(-1)
        squared[1:-1] = np.minimum(squared[1:-1], allowed)
    squared = np.minimum(squared, np.square(cap))
    # v(s)^2 <= v(s')^2 + 2 a (s' - s) for every s' ahead
    ahead = np.minimum.accumulate((squared + 2 * deceleration * lengths)[::-1])[::-1]
    return JointPath(lengths, joints, np.sqrt(np.maximum(ahead - 2 * deceleration * lengths, 0.0)))


def timed_tool_path(
    distances: Array,
    joints: Array,
    deceleration: float,
    limits: JointLimits,
    share: float,
    cap: ArrayLike,
) -> JointPath:
    """A tool path with its speed: s grows with the way of the head, and faster where a joint turns far.

    Args:
        distances: Of the head along the path [m], shape (N,), strictly rising.
        joints: [rad], shape (N, 6).
        deceleration: Of s, with which slower parts ahead are met.
        limits: Of the joints.
        share: Of the joints' speed and acceleration that may be used, 0..1.
        cap: Largest speed of the head [m/s], at each sample or one for all.
    """
    moved = np.diff(distances)
    steps = np.maximum(moved, LEVER * np.abs(np.diff(joints, axis=0)).max(-1))
    stretch = steps / moved  # ds/dx of each step; a sample heeds the lesser of both sides
    stretch = np.minimum(np.append(stretch, stretch[-1]), np.insert(stretch, 0, stretch[0]))
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    return timed_path(lengths, joints, deceleration, limits, share, stretch * cap)


def joint_move(start: ArrayLike, *goals: ArrayLike, limits: JointLimits = RM65_LIMITS) -> tuple[Array, Array]:
    """Straight lines in joint space; s is the travel of the joint that travels most [rad].

    Args:
        start: Joints [rad], shape (6,).
        goals: Joints to pass, the last one the end; equal neighbours add nothing.
        limits: Of the joints.

    Returns:
        Lengths, shape (N,), and joints [rad], shape (N, 6).

    Raises:
        JointLimitError: When a goal lies outside the limits.
    """
    knots = [np.asarray(start, dtype=float)]
    for goal in goals:
        limits.check(goal)
        if np.abs(np.asarray(goal) - knots[-1]).max() > 1e-6:
            knots.append(np.asarray(goal, dtype=float))
    if len(knots) == 1:
        knots.append(knots[0])
    lengths, joints = [np.zeros(1)], [knots[0][None]]
    for before, after in pairwise(knots):
        travel = max(float(np.abs(after - before).max()), 1e-6)
        parts = np.linspace(0.0, 1.0, max(int(np.ceil(travel / SAMPLE_TURN)), 2) + 1)[1:]
        lengths.append(lengths[-1][-1] + parts * travel)
        joints.append(before + parts[:, None] * (after - before))
    return np.concatenate(lengths), np.concatenate(joints)


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


def solve_path(
    kinematics: Kinematics, poses: ArrayLike, seed: ArrayLike, limits: JointLimits = RM65_LIMITS
) -> Array:
    """Joint angles along a path of head poses, on one branch, without jumps.

    Args:
        kinematics: The arm.
        poses: T_base_head, shape (N, 4, 4), closely spaced.
        seed: Joints [rad], shape (6,), from which the path begins; decides the branch.
        limits: Of the joints.

    Returns:
        Joints [rad], shape (N, 6).

    Raises:
        UnreachableError: Out of reach, outside the limits, or through a singularity where the wrist
            would flip.
    """
    solutions = solve_head(kinematics, poses, limits)
    start = nearest(solutions[0], seed, limits)
    branch = int(np.nanargmin(np.abs(wrap(solutions[0] - start)).max(-1)))
    chosen = solutions[:, branch]
    lost = np.isnan(chosen).any(-1)
    if lost.any():
        index = int(np.argmax(lost))
        _continuous(chosen[:index], start, limits)  # a joint may meet its limit before that
        raise UnreachableError(
            f"pose {index} of {len(lost)} of the path is out of reach; bring it nearer", index
        )
    return _continuous(chosen, start, limits)


def _continuous(joints: Array, start: Array, limits: JointLimits) -> Array:
    """Unwrap whole turns along the path and refuse what jumps or leaves the limits."""
    joints = np.unwrap(joints, axis=0)
    joints += start - joints[0]
    steps = np.abs(np.diff(joints, axis=0)).max(-1, initial=0.0)
    if steps.size and steps.max() > LARGEST_STEP:
        index = int(np.argmax(steps)) + 1
        raise UnreachableError(
            f"pose {index} of the path turns a joint by {steps.max():.2f} rad at once (singular posture); "
            "choose another direction of travel",
            index,
        )
    outside = ~limits.contain(joints)
    if outside.any():
        index = int(np.argmax(outside))
        raise UnreachableError(
            f"pose {index} of {len(joints)} of the path needs a joint beyond its limits", index
        )
    return joints
