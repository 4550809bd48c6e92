"""Plans the arm's motions as joint paths, before anything moves: to a stand-off, straight lines, home.

What cannot be done is refused here, with the reason. A body is not known to the driver, so a path
through free air must stay on the arm's side of the plane through its end nearest to the person.
"""

from dataclasses import dataclass
from itertools import pairwise, permutations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.errors import NotReadyError, UnreachableError
from bathbot_scrub.rm65.inverse_kinematics import check_poses, solve_head, unwind, within_limits
from bathbot_scrub.rm65.joint_path import (
    SAMPLE_STEP,
    JointPath,
    densify,
    joint_move,
    solve_path,
    timed_path,
    timed_tool_path,
)
from bathbot_scrub.rm65.kinematics import HEAD_LENGTH, Kinematics
from bathbot_scrub.rm65.limits import RM65_LIMITS, JointLimits
from bathbot_scrub.rm65.path_runner import Pace

Array = NDArray[np.float64]
_PLANE_SLACK = 0.02  # [m] that any link may pass the plane through the end next to the person
_DETOUR = 1.6  # longest way of the head over the straight distance
_DETOUR_FREE = 0.15  # [m] that are no detour
LINE_DECELERATION = 0.25  # [m/s^2] with which slower parts of a tool path are met
_BACKS = (0.0, 0.08, 0.16)  # [m] straight back from the person before the joints fold
_NEAR_SIDE = 0.03  # [m] towards the person that a way home may use, after a retract of 0.10 m
_ROOM, _ROOM_WEIGHT = (
    0.7,
    10.0,
)  # [rad] wanted about a posture that paths begin from; its worth against travel
_GROUPS = (slice(0, 1), slice(1, 3), slice(3, 6))  # joints of base, arm and wrist
_LINE_STEP = 0.002  # [m] between samples of a straight line: its joints bend little
_RAMP_TIME = 0.1  # [s] in which an acceleration is reached


@dataclass(frozen=True, slots=True)
class Planner:
    """Plans for one arm."""

    kinematics: Kinematics
    home: Array  # folded posture [rad], shape (6,): the wrist may turn freely there
    joint_pace: Pace
    joint_share: float  # of the joints' limits that tool paths may use
    limits: JointLimits = RM65_LIMITS

    def joint_path(self, start: ArrayLike, *goals: ArrayLike) -> JointPath:
        """Straight in joint space; s is the travel of the fastest joint [rad].

        Raises:
            JointLimitError: When a goal lies outside the limits.
        """
        lengths, joints = joint_move(start, *goals, limits=self.limits)
        return timed_path(lengths, joints, self.joint_pace.acceleration, self.limits, 1.0)

    def to_pose(self, start: ArrayLike, T_base_head: Array) -> JointPath:
        """Joint path to a head pose whose z axis points at the person.

        Of the solutions with most room for a path around the pose, then with least travel, the first
        whose way stays on the arm's side of the pose.

        Args:
            start: Joints now [rad], shape (6,).
            T_base_head: Where to, (4, 4).

        Raises:
            UnreachableError: No solution, or none with a clear way.
        """
        start = np.asarray(start, dtype=float)
        solutions = within_limits(
            unwind(solve_head(self.kinematics, T_base_head, self.limits), start), self.limits
        )
        cost = np.abs(solutions - start).sum(-1) + _ROOM_WEIGHT * (_ROOM - self._room(solutions))
        order = [int(i) for i in np.argsort(cost) if np.isfinite(cost[i])]
        if not order:
            raise UnreachableError(
                f"no joint solution for the head at {_place(T_base_head)}; bring the target nearer"
            )
        reasons = []
        for branch in order:
            try:
                return self.joint_path(start, *reversed(self._way(solutions[branch], start, T_base_head)))
            except UnreachableError as error:
                reasons.append(str(error))
        raise UnreachableError(f"no clear way to {_place(T_base_head)}: {reasons[0]}; call arm/home first")

    def to_home(self, start: ArrayLike) -> JointPath:
        """Joint path to the folded posture, from where the head may still be near the person.

        Raises:
            UnreachableError: With what is in the way.
        """
        start = np.asarray(start, dtype=float)
        side = retreated(self.kinematics.head(start), -_NEAR_SIDE)
        return self.joint_path(start, *self._way(start, self.home, side)[1:], self.home)

    def _way(self, near: Array, far: Array, side: Array) -> list[Array]:
        """Joints to pass from `near` the person to `far`, the last left out: straight back first if need be.

        Raises:
            UnreachableError: With what is in the way of the most direct way.
        """
        first: UnreachableError | None = None
        T = self.kinematics.head(near)
        for back in _BACKS:
            try:
                line = [near]
                if back:
                    line = list(
                        solve_path(
                            self.kinematics, densify([T, retreated(T, back)], 0.01)[1], near, self.limits
                        )
                    )
                return line + self._folding(line[-1], far, side)
            except UnreachableError as error:
                first = first or error
        raise first or UnreachableError("no way")

    def _folding(self, near: Array, far: Array, side: Array) -> list[Array]:
        """Joints to pass between two postures: none where the head makes no detour, else the arm folded.

        Where the wrist cannot stay as it is while the arm folds, base, arm and wrist move one after
        the other, in the first order that is clear.
        """
        if not self._obstacle(near, far, side):
            return []
        folded_near = np.concatenate([self.home[:3], near[3:]])
        folded_far = np.concatenate([self.home[:3], far[3:]])
        reasons = [self._obstacle(*leg, side) for leg in ((near, folded_near), (folded_far, far))]
        if not any(reasons):
            return [folded_near, folded_far]
        ends = np.stack([near, far])
        for order in permutations(_GROUPS):
            way = [near]
            for group in order[:-1]:
                way.append(way[-1].copy())
                way[-1][group] = far[group]
            if not any(self._obstacle(*leg, side, ends) for leg in pairwise([*way, far])):
                return way[1:]
        raise UnreachableError(next(filter(None, reasons)))

    def _room(self, joints: Array) -> Array:
        """How far joints [rad], shape (..., 6), may turn to a limit or a flip of the wrist, 0.._ROOM."""
        room = np.minimum(self.limits.upper - joints, joints - self.limits.lower).min(-1)
        return np.clip(np.minimum(room, np.abs(joints[..., 4])), 0.0, _ROOM)

    def _obstacle(self, start: Array, goal: Array, side: Array, ends: Array | None = None) -> str:
        """Say why a straight way in joint space is not clear; empty when it is.

        Args:
            start: Joints [rad], shape (6,).
            goal: Likewise.
            side: Head pose whose plane across z no link shall pass, (4, 4).
            ends: Postures (N, 6) that may pass it, since they are given; start and goal if left out.
        """
        joints = start + np.linspace(0.0, 1.0, 40)[:, None] * (goal - start)
        points, heads = self._towards(joints, side)
        given = points[[0, -1]] if ends is None else self._towards(ends, side)[0]
        allowed = max(float(side[:3, 2] @ side[:3, 3]), float(given.max()))
        if points.max() - allowed > _PLANE_SLACK:
            return f"the arm would pass its end by {(points.max() - allowed) * 1e3:.0f} mm towards the person"
        way = float(np.linalg.norm(np.diff(heads, axis=0), axis=1).sum())
        straight = float(np.linalg.norm(heads[-1] - heads[0]))
        if way > _DETOUR * straight + _DETOUR_FREE:
            return f"the head would travel {way:.2f} m for {straight:.2f} m"
        return ""

    def _towards(self, joints: Array, side: Array) -> tuple[Array, Array]:
        """How far wrist and head lie along z of `side` [m], (N, 5), and heads, (N, 3), of joints (N, 6)."""
        frames = self.kinematics.link_frames(joints)
        heads = frames[:, 6, :3, 3] + HEAD_LENGTH * frames[:, 6, :3, 2]
        return np.concatenate([frames[:, 3:, :3, 3], heads[:, None]], axis=1) @ side[:3, 2], heads

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
        distances, dense = densify(check_poses(poses), step)
        if len(distances) < 2:
            raise NotReadyError("the path has no length; the head is there already")
        joints = solve_path(self.kinematics, dense, start, self.limits)
        if np.abs(joints[0] - start).max() > 0.02:
            raise UnreachableError("the path does not begin where the arm stands")
        return timed_tool_path(distances, joints, LINE_DECELERATION, self.limits, self.joint_share, cap)

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
        T = self.kinematics.head(start)
        ends = np.stack([T, T])
        ends[1, :3, 3] += along_z * T[:3, 2]
        try:
            return self.tool_path(start, ends, cap, _LINE_STEP)
        except UnreachableError:
            if not 0.0 < shorter < abs(along_z):
                raise
            return self.line(start, np.sign(along_z) * max(0.7 * abs(along_z), shorter), cap, shorter)

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


def retreated(T_base_head: Array, distance: float) -> Array:
    """The head pose `distance` [m] back along its z axis, (4, 4)."""
    T = np.array(T_base_head, dtype=float)
    T[:3, 3] -= distance * T[:3, 2]
    return T


def _place(T: Array) -> str:
    return "({:.3f}, {:.3f}, {:.3f}) m".format(*T[:3, 3])
