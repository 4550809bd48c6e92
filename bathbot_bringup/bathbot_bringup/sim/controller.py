"""The emulated RM65 controller without any wire: joints, motions, force sensor, stop and errors.

It is stepped at 200 Hz. What firmware does inside is not published; this is a plausible arm, not a copy.
Not thread-safe: the emulator holds one lock around it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from bathbot_scrub.rm65.errors import ArmError
from bathbot_scrub.rm65.inverse_kinematics import nearest, solve_head
from bathbot_scrub.rm65.joint_path import joint_move, timed_path
from bathbot_scrub.rm65.kinematics import T_FLANGE_HEAD, Kinematics
from bathbot_scrub.rm65.limits import JointLimits
from bathbot_scrub.rm65.path_runner import Pace, PathRunner
from bathbot_scrub.rm65.tool_path import densify, solve_path
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.arm_faults import (
    COLLISION,
    FORCE_SENSOR,
    JOINT_DISABLED,
    BodyFaults,
    JointTrouble,
    joint_trouble,
)
from bathbot_bringup.sim.brush import Brush, Contact, SkinSurface
from bathbot_bringup.sim.controller_force import ForceSensor
from bathbot_bringup.sim.fault_schedule import FaultSchedule
from bathbot_bringup.sim.joint_dynamics import JointDynamics
from bathbot_bringup.sim.pushed_surface import PushedSurface

Array = NDArray[np.float64]
STEP = 0.005  # [s]
LINE_SPEED, LINE_ACCELERATION = 0.25, 1.6  # [m/s], [m/s^2] of movel at v = 100
_LARGEST_FRAME_STEP = np.radians(10.0)  # per frame of the stream; else the joint does not respond
_STREAM_END = 0.1  # [s] without frames after which a stream is over
_FAR = 0.10  # [m] of gap above which contact is looked for at 20 Hz only

TARGET_OVER_LIMIT, UNREACHABLE, OVER_SPEED = 0x1002, 0x1003, 0x1009  # the controller's error codes
_TRIPS = (COLLISION, JOINT_DISABLED)


class Motion(Enum):
    """What the arm does, in the words of the state push."""

    IDLE = "idle"
    MOVE_J = "move_J"
    MOVE_L = "move_L"
    STREAM = "movej_canfd"
    STOP = "stop"
    SLOW_STOP = "slow_stop"
    PAUSE = "pause"


class Settled(NamedTuple):
    """A planned motion that has ended; true when it reached its goal."""

    reached: bool


@dataclass(frozen=True, slots=True)
class Arm:
    """Which arm is emulated."""

    kinematics: Kinematics
    limits: JointLimits
    brush: Brush
    generation: int = 3


class Controller:
    """An arm that can be told to move and asked how it is."""

    def __init__(
        self,
        arm: Arm,
        joints: ArrayLike,
        surface: SkinSurface,
        clock: Callable[[], float],
        rng: np.random.Generator,
        faults: FaultSchedule | None = None,
    ) -> None:
        """Stand still at `joints` [rad], shape (6,).

        Args:
            arm: Kinematics, limits and brush.
            joints: Where to begin.
            surface: What the brush may touch.
            clock: Time of the body [s].
            rng: Source of the sensor's noise.
            faults: What fails, looked at in every step.
        """
        self.arm, self.surface, self.clock = arm, PushedSurface(surface), clock
        self.faults = faults or FaultSchedule()
        self.dynamics = JointDynamics(joints, arm.limits)
        self.target = self.dynamics.joints
        self.sensor = ForceSensor(rng, self.faults, STEP)
        self.motion = Motion.IDLE
        self.error = 0
        self.joint_codes = [0] * 6
        self.power = True
        self._body_faults = BodyFaults(self.surface, STEP)
        self._ends: list[Settled] = []
        self._runner: PathRunner | None = None
        self._paused_motion = Motion.IDLE
        self._since_frame = 0.0
        self._until_touch = 0
        self.T_base_flange = arm.kinematics.flange(joints)
        self.contact = Contact(-_FAR, 0.0, np.zeros(3), np.zeros(3), "")

    @property
    def T_base_head(self) -> Array:
        """True pose of the scrub head, (4, 4)."""
        return self.T_base_flange @ T_FLANGE_HEAD

    @property
    def busy(self) -> bool:
        """Whether a planned motion is on its way, pauses included."""
        return self._runner is not None

    def move_joints(self, goal: Array, share: float) -> None:
        """Accept a movej to `goal` [rad] at `share` of the joints' speed, 0..1.

        Raises:
            JointLimitError: Beyond a joint's limit.
        """
        limits = self.arm.limits
        lengths, joints = joint_move(self.target, goal, limits=limits)
        acceleration = np.radians(600.0)
        path = timed_path(lengths, joints, acceleration, limits, share)
        self._begin(
            path, Pace(float(limits.speed.max()) * share, acceleration, 10.0 * acceleration), Motion.MOVE_J
        )

    def move_to_pose(self, T_base_flange: Array, share: float) -> None:
        """Accept a movej_p: joints move to a pose of the flange.

        Raises:
            ArmError: Out of reach.
        """
        solutions = solve_head(self.arm.kinematics, T_base_flange @ T_FLANGE_HEAD, self.arm.limits)
        self.move_joints(nearest(solutions, self.target, self.arm.limits), share)

    def move_line(self, T_base_flange: Array, share: float) -> None:
        """Accept a movel to a pose of the flange at `share` of 0.25 m/s.

        Raises:
            ArmError: Out of reach, or through a singularity.
        """
        ends = np.stack([self.arm.kinematics.head(self.target), T_base_flange @ T_FLANGE_HEAD])
        lengths, poses = densify(ends)
        if len(lengths) < 2:
            lengths, poses = np.array([0.0, 1e-6]), np.concatenate([poses, poses])
        joints = solve_path(self.arm.kinematics, poses, self.target, self.arm.limits)
        path = timed_path(lengths, joints, LINE_ACCELERATION, self.arm.limits, 1.0)
        self._begin(path, Pace(LINE_SPEED * share, LINE_ACCELERATION, 20 * LINE_ACCELERATION), Motion.MOVE_L)

    def _begin(self, path, pace: Pace, motion: Motion) -> None:
        self.error, self.joint_codes = 0, [0] * 6  # a new motion clears an error that was kept
        self._runner, self.motion = PathRunner(path, pace, STEP), motion

    def stream(self, goal: Array) -> None:
        """Take one frame of the joint stream [rad]; a step too far is not followed but reported."""
        if (
            not self.power
            or self.tripped
            or self.busy
            or (self.motion in (Motion.STOP, Motion.SLOW_STOP) and not self.at_rest)
        ):
            return
        if not self.arm.limits.contain(goal):
            self.error = TARGET_OVER_LIMIT
        elif np.abs(goal - self.target).max() > _LARGEST_FRAME_STEP:
            self.error = OVER_SPEED
        else:
            self.error, self.target = 0, goal
            self.motion, self._since_frame = Motion.STREAM, 0.0

    @property
    def at_rest(self) -> bool:
        """Whether the joints stand still where they were told to be."""
        return self.dynamics.at_rest(self.target)

    def stop(self, slow: bool = False) -> None:
        """Brake; a planned motion is given up."""
        self.motion = Motion.SLOW_STOP if slow else Motion.STOP
        if self._runner is not None:
            pace = self._runner.pace
            self._runner.brake(Pace(pace.speed, (1.0 if slow else 2.0) * pace.acceleration, 4.0 * pace.jerk))

    @property
    def tripped(self) -> bool:
        """Whether a fault of the arm keeps the joint stream from being obeyed, until errors are cleared."""
        return self.error in _TRIPS

    @property
    def system_error(self) -> int:
        """Error of a part beside the arm itself, 0: none."""
        return FORCE_SENSOR if "dead_force" in self.faults else 0

    def trip(self, trouble: JointTrouble) -> None:
        """Stop as fast as the joints can because of a fault of the arm; a planned motion is lost."""
        if not self.tripped:
            self.target = self.dynamics.stopping_point()
            self.motion = Motion.STOP
            if self._runner is not None:
                self._runner = None
                self._ends.append(Settled(False))
        for joint in trouble.stuck:  # it must not jump to where it should have been once it is free
            self.target[joint] = self.dynamics.positions[joint]
        self.error = trouble.error
        if trouble.code:
            self.joint_codes[trouble.joint] = trouble.code

    def clear_errors(self) -> None:
        """Forget errors; what still lasts raises them again."""
        self.error, self.joint_codes = 0, [0] * 6

    def cut_power(self) -> None:
        """Lose every motion at once: brakes hold the joints, nobody is told."""
        self.power, self._runner, self.motion = False, None, Motion.IDLE
        self.target = self.dynamics.joints
        self.clear_errors()

    def pause(self) -> None:
        """Brake on the path of a planned motion and wait there."""
        if self._runner is not None and self.motion is not Motion.PAUSE:
            self._paused_motion, self.motion = self.motion, Motion.PAUSE
            self._runner.brake()

    def go_on(self) -> None:
        """Go on after a pause."""
        if self._runner is not None and self.motion is Motion.PAUSE:
            self.motion = self._paused_motion
            self._runner.go_on()

    def step(self) -> list[Settled]:
        """Advance by 5 ms; give the ends of planned motions."""
        trouble = joint_trouble(self.faults, self.dynamics.positions, self.target)
        if trouble.error:
            self.trip(trouble)
        settled = [] if "stalled" in self.faults else self._advance()
        before = self.T_base_head[:3, 3]
        self.dynamics.step(self.target, STEP, trouble.stuck)
        self.T_base_flange = self.arm.kinematics.flange(self.dynamics.joints)
        self._touch((self.T_base_head[:3, 3] - before) / STEP)
        self.sensor.measure(self.T_base_flange, self.contact.force, self.contact.torque)
        return settled

    def _advance(self) -> list[Settled]:
        ends, self._ends = self._ends, []
        runner = self._runner
        if ends:
            return ends
        if runner is None:
            self._since_frame += STEP
            over = self.motion is not Motion.STREAM or self._since_frame > _STREAM_END
            if over and self.motion is not Motion.IDLE and self.at_rest:
                self.motion = Motion.IDLE
            return []
        try:
            self.target = runner.step()
        except ArmError:
            self._runner, self.motion, self.error = None, Motion.IDLE, OVER_SPEED
            return [Settled(False)]
        stopped = self.motion in (Motion.STOP, Motion.SLOW_STOP) and runner.at_rest
        if (runner.at_end or stopped) and self.at_rest:
            self._runner, self.motion = None, Motion.IDLE
            return [Settled(not stopped)]
        return []

    def _touch(self, velocity: Array) -> None:
        """Ask the surface, seldom while far away: its answer costs most of a step."""
        pressed = self.contact.compression > 0.0
        self._body_faults.step(self.faults, self.T_base_head, self.clock(), pressed)
        self._until_touch -= 1
        if self._until_touch > 0:
            return
        self.contact = self.arm.brush.touch(self.T_base_head, velocity, self.surface, self.clock())
        self._until_touch = 10 if self.contact.compression < -_FAR / 2 else 1
