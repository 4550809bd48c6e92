"""Planned motions of the emulated arm: joint moves, lines, arcs and curves, from joints to joints.

Corners between connected motions are not blended: each piece comes to rest.
"""

from enum import Enum
from typing import NamedTuple

import numpy as np
from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.joint_limits import JointLimits
from bathbot_scrub.arm.tool_path import densify, solve_path, step_lengths
from bathbot_scrub.rm65.arm.inverse_kinematics import solve_head
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.paths.joint_path import JointPath, joint_move, timed_path
from bathbot_scrub.rm65.paths.path_runner import Pace
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, Slerp

from bathbot_bringup.sim.arm.controller.arm_setup import Speeds

Array = NDArray[np.float64]
_TURN_LENGTH = 0.1  # [m/rad] that a turn on the spot counts in `densify`
_ARC_STEP = 0.005  # [m] between the points that make an arc or a curve
_STRAIGHT = 1e-3  # sine of the angle below which three points make no circle
_FARTHEST = 0.6  # [m] of a line that is taught


class Motion(Enum):
    """What the arm does, in the words of the state push."""

    IDLE = "idle"
    MOVE_J = "move_J"
    MOVE_L = "move_L"
    MOVE_C = "move_C"
    MOVE_S = "move_S"
    STREAM = "move_through_joint"
    STREAM_POSE = "move_through_pose"
    STREAM_FORCE = "move_through_force_pose"
    STREAM_VELOCITY = "movev_canfd"
    TEACH = "tech_demonstration"
    STOP = "stop"
    SLOW_STOP = "slow_stop"
    PAUSE = "pause"


class Plan(NamedTuple):
    """One piece of planned motion."""

    path: JointPath
    pace: Pace
    motion: Motion
    corners: tuple[Array, ...] = ()  # poses of the flange, (4, 4), that a curve passes


class ArcError(UnreachableError):
    """Three points that make no circle."""


class Planner:
    """Plans pieces of motion for one arm."""

    def __init__(self, kinematics: RM65, limits: JointLimits, speeds: Speeds) -> None:
        """Plan within the limits and speeds as they are now."""
        self._kinematics, self._limits, self._speeds = kinematics, limits, speeds

    def joints(self, start: Array, goal: Array, share: float, motion: Motion = Motion.MOVE_J) -> Plan:
        """Joint move to `goal` [rad] at `share` of the joints' speed, 0..1.

        Raises:
            JointLimitError: Beyond a joint's limit.
        """
        lengths, joints = joint_move(start, goal, limits=self._limits)
        acceleration = float(self._limits.acceleration.max())
        path = timed_path(lengths, joints, acceleration, self._limits, share)
        pace = Pace(float(self._limits.speed.max()) * share, acceleration, 10.0 * acceleration)
        return Plan(path, pace, motion)

    def pose(self, start: Array, T_base_flange: Array, share: float) -> Plan:
        """Joint move to a pose of the flange.

        Raises:
            ArmError: Out of reach.
        """
        return self.joints(start, self._near(start, T_base_flange), share)

    def line(self, start: Array, T_base_flange: Array, share: float) -> Plan:
        """Straight line to a pose of the flange, at `share` of the tool's speed.

        Raises:
            ArmError: Out of reach, or through a singularity.
        """
        ends = np.stack([self._kinematics.flange(start), T_base_flange])
        return self._through(start, ends, share, Motion.MOVE_L)

    def arc(self, start: Array, T_via: Array, T_to: Array, share: float, loops: int) -> Plan:
        """Circle through two poses of the flange, `loops` times around and then to the second.

        Raises:
            ArmError: Out of reach, or three points on a line.
        """
        T_from = self._kinematics.flange(start)
        points, shares = _circle(T_from[:3, 3], T_via[:3, 3], T_to[:3, 3], loops)
        poses = np.tile(np.eye(4), (len(points), 1, 1))
        poses[:, :3, 3] = points
        poses[:, :3, :3] = _turned(np.stack([T_from, T_to]), np.array([0.0, 1.0]), shares)
        return self._through(start, poses, share, Motion.MOVE_C)

    def curve(self, start: Array, poses: Array, share: float) -> Plan:
        """Smooth curve through poses of the flange, shape (N, 4, 4).

        Raises:
            ArmError: Out of reach.
        """
        knots = np.concatenate([self._kinematics.flange(start)[None], poses])
        keep = np.concatenate([[True], step_lengths(knots) > 1e-6])
        knots = knots[keep]
        if len(knots) > 2:
            at = np.concatenate([[0.0], np.cumsum(step_lengths(knots))])
            fine = np.linspace(0.0, at[-1], max(int(at[-1] / _ARC_STEP), 8))
            dense = np.tile(np.eye(4), (len(fine), 1, 1))
            dense[:, :3, 3] = CubicSpline(at, knots[:, :3, 3])(fine)
            dense[:, :3, :3] = _turned(knots, at, fine)
            knots = dense
        plan = self._through(start, knots, share, Motion.MOVE_S)
        return plan._replace(corners=tuple(poses))

    def far_line(self, start: Array, direction: Array, share: float) -> Plan:
        """Line along a direction of the base, shape (3,), as far as the arm reaches; for teaching.

        Raises:
            ArmError: Nowhere to go.
        """
        T, distance = self._kinematics.flange(start), _FARTHEST
        while True:
            goal = T.copy()
            goal[:3, 3] += distance * direction
            try:
                return self.line(start, goal, share)._replace(motion=Motion.TEACH)
            except UnreachableError:
                if distance < 0.002:
                    raise
                distance *= 0.6

    def _near(self, start: Array, T_base_flange: Array) -> Array:
        T_base_head = T_base_flange @ self._kinematics.tool.T_flange_head
        solutions = solve_head(self._kinematics, T_base_head, self._limits)
        return nearest(solutions, start, self._limits)

    def _through(self, start: Array, flanges: Array, share: float, motion: Motion) -> Plan:
        lengths, poses = densify(flanges @ self._kinematics.tool.T_flange_head)
        if len(lengths) < 2:
            lengths, poses = np.array([0.0, 1e-6]), np.concatenate([poses, poses])
        joints = solve_path(self._kinematics, poses, start, self._limits)
        turn = float(
            (Rotation.from_matrix(poses[:-1, :3, :3]).inv() * Rotation.from_matrix(poses[1:, :3, :3]))
            .magnitude()
            .sum()
        )
        speeds, stretch = self._speeds, lengths[-1] / max(turn, 1e-9)
        speed = min(speeds.line, speeds.angular * stretch) * share
        acceleration = min(speeds.line_acceleration, speeds.angular_acceleration * stretch)
        path = timed_path(lengths, joints, acceleration, self._limits, 1.0)
        return Plan(path, Pace(max(speed, 1e-3), acceleration, 20.0 * acceleration), motion)


def _turned(poses: Array, at: Array, where: Array) -> Array:
    """Rotations between poses at parameters `at`, shape (N,), taken at `where`, shape (M,) -> (M, 3, 3)."""
    return Slerp(at, Rotation.from_matrix(poses[:, :3, :3]))(np.clip(where, at[0], at[-1])).as_matrix()


def _circle(first: Array, via: Array, last: Array, loops: int) -> tuple[Array, Array]:
    """Points [m] of a circle from `first` through `via` to `last`, and their share of the way, 0..1.

    Raises:
        ArcError: When the three lie on a line.
    """
    a, b = via - first, last - first
    normal = np.cross(a, b)
    if np.linalg.norm(normal) < _STRAIGHT * max(np.linalg.norm(a) * np.linalg.norm(b), 1e-12):
        raise ArcError("three points on a line make no circle; choose another point on the way")
    to_centre = np.cross(normal, a) * (b @ b) + np.cross(b, normal) * (a @ a)
    centre = first + to_centre / (2.0 * normal @ normal)
    across = first - centre
    along = np.cross(normal / np.linalg.norm(normal), across)
    end = np.arctan2((last - centre) @ along, (last - centre) @ across) % (2.0 * np.pi)
    whole = end + 2.0 * np.pi * loops
    count = max(int(np.ceil(whole * np.linalg.norm(across) / _ARC_STEP)), 8)
    angles = np.linspace(0.0, whole, count + 1)
    points = centre + np.cos(angles)[:, None] * across + np.sin(angles)[:, None] * along
    return points, angles / whole
