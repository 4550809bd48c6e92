"""Plans the arm's motions as joint paths, before anything moves: to a stand-off, straight lines, home.

A pose can be held in up to eight postures; `postures` says which are the best to go to, the planner takes the
first to which a path meets nothing. What cannot be done is refused here, with the reason.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.branches import unwind, within_limits
from bathbot_scrub.arm.errors import CollisionError, NotReadyError, UnreachableError
from bathbot_scrub.arm.joint_limits import JointLimits
from bathbot_scrub.arm.tool_path import SAMPLE_STEP, densify, retreated, solve_path
from bathbot_scrub.rm65.arm.inverse_kinematics import check_poses
from bathbot_scrub.rm65.paths.free_space import FreeSpace
from bathbot_scrub.rm65.paths.joint_path import JointPath, joint_move, timed_path, timed_tool_path
from bathbot_scrub.rm65.paths.path_runner import Pace

if TYPE_CHECKING:  # it loads Pinocchio, which not everybody who plans needs
    from bathbot_scrub.rm65.paths.surroundings import Surroundings

Array = NDArray[np.float64]
_ROOM = 0.7  # [rad] wanted about a posture that paths begin from
_ROOM_WEIGHT = 10.0  # its worth against travel
LINE_DECELERATION = 0.25  # [m/s^2] with which slower parts of a tool path are met
_NEAR_SIDE = 0.03  # [m] towards the person that a way home may use, after a retract of 0.10 m
_TRIED = 6  # tried for each posture; checking one takes some milliseconds
_LINE_STEP = 0.002  # [m] between samples of a straight line: its joints bend little
_SHORT_OF_REACH = 0.9  # share of a line within reach to make do with: joints race at its end
_RAMP_TIME = 0.1  # [s] in which an acceleration is reached


@dataclass(frozen=True, slots=True)
class MotionPlanner:
    """Plans for one arm."""

    arm: Arm
    home: Array  # folded posture [rad], shape (6,): the wrist may turn freely there
    joint_pace: Pace
    joint_share: float  # of the joints' limits that tool paths may use
    surroundings: "Surroundings | None" = None  # what paths must not meet; None: nothing is known

    def __post_init__(self) -> None:
        """Compile the inverse kinematics now, before anything moves."""
        self.arm.solve_head(self.arm.head(self.home))

    @property
    def limits(self) -> JointLimits:
        """Those of the arm."""
        return self.arm.limits

    def joint_path(self, start: ArrayLike, *goals: ArrayLike) -> JointPath:
        """Straight in joint space; s is the travel of the fastest joint [rad].

        Raises:
            JointLimitError: When a goal lies outside the limits.
        """
        lengths, joints = joint_move(start, *goals, limits=self.limits)
        return timed_path(lengths, joints, self.joint_pace.acceleration, self.limits, 1.0)

    def slow_near_people(self, path: JointPath, cap: ArrayLike = np.inf) -> JointPath:
        """A path through free air at the speed that people near by allow.

        Args:
            path: In joint space; s is the travel of the fastest joint [rad].
            cap: Largest ds/dt wanted, at each sample or one for all.
        """
        if self.surroundings is None:
            return path
        caps = np.minimum(cap, self.surroundings.caps(path.lengths, path.joints))
        return timed_path(path.lengths, path.joints, self.joint_pace.acceleration, self.limits, 1.0, caps)

    def to_pose(self, start: ArrayLike, T_base_head: Array, patch: ArrayLike = ()) -> JointPath:
        """Joint path to a head pose whose z axis points at the person.

        Of the solutions with most room for a path around the pose, then with least travel, the first
        whose way stays on the arm's side of the pose and meets nothing.

        Args:
            start: Joints now [rad], shape (6,).
            T_base_head: Where to, (4, 4).
            patch: Places, shape (K, 3) [m], about which the head may touch the body.

        Raises:
            UnreachableError: No solution, or none with a clear way; a CollisionError when something known
                is in the way.
            NotReadyError: The body was seen too long ago.
        """
        return next(self._paths_to(np.asarray(start, dtype=float), T_base_head, patch))

    def to_touch(
        self, start: ArrayLike, T_base_target: Array, standoff: float, extra: float, cap: float
    ) -> tuple[JointPath, JointPath]:
        """Joint path to a stand-off before a target, and the straight line from there that ends beyond it.

        Args:
            start: Joints now [rad], shape (6,).
            T_base_target: Head pose on the skin, z into it, (4, 4).
            standoff: Distance at which the line begins [m].
            extra: Beyond the target where it ends [m].
            cap: Largest speed on the line [m/s].

        Raises:
            UnreachableError, NotReadyError: As `to_pose`, for both parts together.
        """
        patch = T_base_target[None, :3, 3]
        first = None
        for way in self._paths_to(np.asarray(start, dtype=float), retreated(T_base_target, standoff), patch):
            try:
                line = self.line(way.joints[-1], standoff + extra, cap)
                self.check(line.joints, patch)
                return way, line
            except UnreachableError as error:
                first = first or error
        raise first or UnreachableError("no way to the target")

    def to_home(self, start: ArrayLike, came: JointPath | None = None) -> JointPath:
        """Joint path to the folded posture, from where the head may still be near the person.

        Args:
            start: Joints now [rad], shape (6,).
            came: The way on which the arm came from there: known to be free, so it is taken back if it can.

        Raises:
            UnreachableError: With why not, for each way that was tried.
        """
        start = np.asarray(start, dtype=float)
        T, free = self.arm.head(start), self._free_space
        side = retreated(T, -_NEAR_SIDE)
        folding = ([*way[1:], self.home] for way in free.waypoints(start, self.home, side))
        tried = {"folding first": folding}
        if came is not None:
            back = free.straight_back(start, came, side)
            tried = {"as it came": free.over_the_skin(start, came), **tried, "by its stand-off": back}
        refused: dict[str, list[str]] = {}  # the ways that meet one obstacle, by what it is
        for name, ways in tried.items():
            try:
                return self._first_clear((self.joint_path(start, *way) for way in ways), T[None, :3, 3])
            except UnreachableError as error:
                refused.setdefault(str(error), []).append(name)
        reasons = (f"{', '.join(names)}: {why}" for why, names in refused.items())
        raise UnreachableError(f"no way home: {'; '.join(reasons)}")

    def check(self, joints: ArrayLike, patch: ArrayLike = ()) -> None:
        """Refuse a joint path, shape (N, 6) [rad], that would meet something; see `Surroundings.check`."""
        if self.surroundings is not None:
            self.surroundings.check(joints, patch, self.surroundings.margin)

    def free_part(self, joints: Array, patch: ArrayLike = ()) -> int:
        """How many of the joints of a path, (N, 6), lie before the body; see `Surroundings.free_part`."""
        if self.surroundings is None:
            return len(joints)
        return self.surroundings.free_part(joints, patch, self.surroundings.margin)

    def check_tool_path(self, joints: ArrayLike, T_base_heads: Array) -> None:
        """The same for a slow path along head poses, shape (N, 4, 4), all of which may touch the body."""
        if self.surroundings is not None:
            self.surroundings.trust()
            self.surroundings.check(joints, T_base_heads[:, :3, 3], self.surroundings.scrub_margin)

    def _paths_to(self, start: Array, T_base_head: Array, patch: ArrayLike) -> Iterator[JointPath]:
        """Clear joint paths to a head pose, one for each solution that has one, the best first."""
        if self.surroundings is not None:
            self.surroundings.trust()
        first, found = None, False
        for posture in postures(self.arm, T_base_head, start, self.limits):
            ways = self._free_space.waypoints(posture, start, T_base_head)
            try:
                path = self._first_clear((self.joint_path(start, *reversed(way)) for way in ways), patch)
            except UnreachableError as error:
                first = first or error
                continue
            found = True
            yield path
        if isinstance(first, CollisionError) and not found:
            raise first
        if not found:
            raise UnreachableError(f"no clear way to {_place(T_base_head)}: {first}; call arm/home first")

    def _first_clear(self, paths: Iterable[JointPath], patch: ArrayLike) -> JointPath:
        """The first of some paths that meets nothing; else the error of the first."""
        first = None
        for path in islice(paths, _TRIED):
            try:
                self.check(path.joints, patch)
                return self.slow_near_people(path)
            except CollisionError as error:
                first = first or error
        raise first or UnreachableError("no way")

    @property
    def _free_space(self) -> FreeSpace:
        return FreeSpace(self.arm, self.home, self.limits)

    def tool_path(
        self, start: ArrayLike, poses: ArrayLike, cap: float, step: float = SAMPLE_STEP
    ) -> JointPath:
        """Straight lines and slerp through head poses, (N, 4, 4), that begin where `start` [rad] is.

        Args:
            start: Joints at the first pose, shape (6,).
            poses: Head poses.
            cap: Largest speed [m/s].
            step: Between samples [m].

        Raises:
            UnreachableError: Out of reach, outside the limits, or through a singularity.
        """
        return self._tool_path(start, *densify(check_poses(poses), step), cap)

    def line(self, start: ArrayLike, along_z: float, cap: float, shorter: float = 0.0) -> JointPath:
        """Straight along the head's z axis, from the joints `start` [rad].

        Args:
            start: Joints now, shape (6,).
            along_z: Distance [m]; negative leaves the skin.
            cap: Largest speed [m/s].
            shorter: Least distance [m] to make do with where all of it is out of reach; 0: none.

        Raises:
            UnreachableError: When not even the shorter line is within reach.
        """
        T = self.arm.head(start)
        distances = np.linspace(0.0, abs(along_z), max(int(np.ceil(abs(along_z) / _LINE_STEP)), 1) + 1)
        dense = np.tile(T, (len(distances), 1, 1))
        dense[:, :3, 3] += np.sign(along_z) * distances[:, None] * T[:3, 2]
        try:
            return self._tool_path(start, distances, dense, cap)
        except UnreachableError as error:
            reach = distances[max(error.index - 1, 0)]
            if not 0.0 < shorter <= reach:
                raise
        return self.line(start, np.sign(along_z) * max(_SHORT_OF_REACH * reach, shorter), cap)

    def _tool_path(self, start: ArrayLike, distances: Array, dense: Array, cap: float) -> JointPath:
        """Through closely spaced head poses, (N, 4, 4), at distances along the path, (N,) [m]."""
        if not distances[-1]:
            raise NotReadyError("the path has no length; the head is there already")
        joints = solve_path(self.arm, dense, start, self.limits)
        if np.abs(joints[0] - start).max() > 0.02:
            raise UnreachableError("the path does not begin where the arm stands")
        return timed_tool_path(distances, joints, LINE_DECELERATION, self.limits, self.joint_share, cap)

    def lead_in(self, T_now: Array, T_first: Array, lift: float, longest: float) -> Array:
        """Head poses from where the head touches to the first pose of a path, shape (N, 4, 4).

        Near by, straight along the skin; farther, up by `lift` [m], over and down again.

        Raises:
            UnreachableError: When it is farther than `longest` [m].
        """
        away = float(np.linalg.norm(T_first[:3, 3] - T_now[:3, 3]))
        if away > longest:
            raise UnreachableError(
                f"the path begins {away:.3f} m from the head, more than {longest} m; approach its start"
            )
        if away < 0.015:
            return np.stack([T_now, T_first])
        up_now, up_first = T_now.copy(), T_first.copy()
        up_now[:3, 3] -= lift * T_now[:3, 2]
        up_first[:3, 3] -= lift * T_first[:3, 2]
        return np.stack([T_now, up_now, up_first, T_first])


def line_pace(speed: float, acceleration: float) -> Pace:
    """A pace along a tool path whose acceleration is reached in a tenth of a second."""
    return Pace(speed, acceleration, acceleration / _RAMP_TIME)


def _place(T: Array) -> str:
    return "({:.3f}, {:.3f}, {:.3f}) m".format(*T[:3, 3])


def postures(arm: Arm, T_base_head: Array, start: Array, limits: JointLimits) -> Array:
    """Joints [rad], shape (N, 6), that hold the head at a pose, (4, 4), the best to go to from `start` first.

    Raises:
        UnreachableError: When there are none; with the reason.
    """
    solutions = within_limits(unwind(arm.solve_head(T_base_head, limits), start, limits), limits)
    cost = np.abs(solutions - start).sum(-1) + _ROOM_WEIGHT * (_ROOM - _room(solutions, limits))
    order = np.argsort(cost)[: np.isfinite(cost).sum()]
    if not len(order):
        place = "({:.3f}, {:.3f}, {:.3f}) m".format(*T_base_head[:3, 3])
        why = arm.why_unreachable(T_base_head, limits)
        raise UnreachableError(f"no joint solution for the head at {place}: {why}")
    return solutions[order]


def _room(joints: Array, limits: JointLimits) -> Array:
    """How far joints [rad], shape (..., 6), may turn to a limit or a flip of the wrist, 0.._ROOM."""
    room = np.minimum(limits.upper - joints, joints - limits.lower).min(-1)
    return np.clip(np.minimum(room, np.abs(joints[..., 4])), 0.0, _ROOM)
