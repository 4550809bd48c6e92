"""A geometric path in joint space: dense samples over a length, without time.

The length s is what the motion is about: metres of tool path, or radians of the fastest joint. Along a
tool path a joint that turns far counts as length too, so that a speed and an acceleration of s bound
those of every joint. Time comes from `PathRunner`, which may stop anywhere and go on.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.joint_limits import JointLimits
from bathbot_scrub.arm.tool_path import SAMPLE_TURN

Array = NDArray[np.float64]
LEVER = 0.1  # [m/rad] by which the travel of a joint counts as length of a tool path


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

    def steepest(self, length: float, ahead: float) -> float:
        """Largest |dq/ds| of any joint from a length to one farther `ahead`."""
        begin, end = np.searchsorted(self.lengths, (length, length + ahead))
        return float(np.abs(self.slopes[max(begin - 1, 0) : end + 1]).max())

    def until(self, length: float) -> "JointPath":
        """The part up to the last sample within a length; two samples at least."""
        kept = max(int(np.searchsorted(self.lengths, length, side="right")), 2)
        return JointPath(self.lengths[:kept], self.joints[:kept], self.speed_limit[:kept])

    def back_from(self, length: float, distance: float) -> "JointPath":
        """The way back from a length, `distance` long or to the beginning."""
        begin = max(length - distance, 0.0)
        inner = self.lengths[(self.lengths > begin + 1e-9) & (self.lengths < length - 1e-9)]
        return self._through(np.concatenate([[max(length, begin + 1e-6)], inner[::-1], [begin]]))

    def on_from(self, length: float, distance: float) -> "JointPath":
        """The way on from a length, `distance` long or to the end."""
        end = min(length + distance, self.end)
        inner = self.lengths[(self.lengths > length + 1e-9) & (self.lengths < end - 1e-9)]
        return self._through(np.concatenate([[min(length, end - 1e-6)], inner, [end]]))

    def _through(self, at: Array) -> "JointPath":
        """Through lengths of this path, shape (N,), rising or falling, at any speed."""
        joints = np.stack([self.at(s) for s in at])
        return JointPath(np.abs(at - at[0]), joints, np.full(len(at), np.inf))

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
    path = JointPath(lengths, joints, np.sqrt(np.minimum(squared, np.square(cap))))
    return slowed(path, deceleration)


def slowed(path: JointPath, deceleration: float, arrival: float = np.inf) -> JointPath:
    """A path on which slower parts ahead, and a speed `arrival` at its end, are met with a deceleration."""
    squared = np.square(path.speed_limit)
    squared[-1] = min(squared[-1], arrival**2)
    # v(s)^2 <= v(s')^2 + 2 a (s' - s) for every s' ahead
    ahead = np.minimum.accumulate((squared + 2 * deceleration * path.lengths)[::-1])[::-1]
    limit = np.sqrt(np.maximum(ahead - 2 * deceleration * path.lengths, 0.0))
    return replace(path, speed_limit=limit)


def joint_move(start: ArrayLike, *goals: ArrayLike, limits: JointLimits) -> tuple[Array, Array]:
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
