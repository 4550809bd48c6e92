"""The emulated RM65 controller without any wire: joints, motions, force sensor, stop and errors.

It is stepped at 200 Hz. What firmware does inside is not published; this is a plausible arm, not a copy.
Not thread-safe: the emulator holds one lock around it.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.arm.controller.arm_health import OVER_SPEED, TARGET_OVER_LIMIT, ArmHealth
from bathbot_bringup.sim.arm.controller.arm_setup import DRIVE_LIMITS, Arm, ArmSetup
from bathbot_bringup.sim.arm.controller.controller_force import ForceSensor
from bathbot_bringup.sim.arm.controller.force_position import ForcePosition
from bathbot_bringup.sim.arm.controller.joint_dynamics import BRAKE, MOTOR, JointDynamics
from bathbot_bringup.sim.arm.controller.joint_stream import LARGEST_STEP, JointStream
from bathbot_bringup.sim.arm.controller.motion_plan import Motion, Plan, Planner
from bathbot_bringup.sim.arm.controller.motion_queue import Ending, MotionQueue, Settled, completion
from bathbot_bringup.sim.arm.controller.skin_contact import SkinContact, collides
from bathbot_bringup.sim.brush import Contact, SkinSurface
from bathbot_bringup.sim.faults.fault_schedule import FaultSchedule
from bathbot_bringup.sim.faults.joint_faults import COLLISION, JointTrouble, joint_trouble
from bathbot_bringup.sim.faults.lasting_fault import Place

Array = NDArray[np.float64]
STEP = 0.005  # [s]
_STOPS = (Motion.STOP, Motion.SLOW_STOP)


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
        self.arm = arm
        self.setup = ArmSetup(replace(arm.limits, acceleration=DRIVE_LIMITS.acceleration))
        self.faults = faults or FaultSchedule()
        self.dynamics = JointDynamics(joints, arm.limits)
        self.target = self.dynamics.joints  # where the joints shall go
        self.sensor = ForceSensor(rng, self.faults, STEP, arm.kinematics.tool)
        self.queue, self._stream = MotionQueue(STEP), JointStream(STEP)
        self.frozen = False  # its program stands still; the joints go on to the last target
        self.force_position: ForcePosition | None = None
        self._yielded = np.zeros(6)  # [rad] by which force control has led away from the motion
        self.motion = Motion.IDLE
        self.health = ArmHealth()
        self._ends: list[Settled] = []
        self.halting = False  # whether the joints brake, whatever the target
        self._hit = False  # whether the contact force is above the collision stage's
        self.T_base_flange = arm.kinematics.flange(joints)
        self.skin = SkinContact(arm.brush, surface, clock, self.faults, STEP)

    @property
    def T_base_head(self) -> Array:
        """True pose of the scrub head, (4, 4)."""
        return self.T_base_flange @ self.arm.kinematics.tool.T_flange_head

    @property
    def contact(self) -> Contact:
        """What the brush meets."""
        return self.skin.now

    @property
    def busy(self) -> bool:
        """Whether a planned motion is on its way, pauses included."""
        return self.queue.busy

    @property
    def at_rest(self) -> bool:
        """Whether the joints stand still where they were told to be."""
        return self.dynamics.at_rest(self.target)

    @property
    def system_error(self) -> int:
        """Error of a part beside the arm itself, 0: none."""
        return self.sensor.reading.error

    @property
    def planner(self) -> Planner:
        """Plans within the limits as they are set."""
        return Planner(self.arm.kinematics, self.setup.limits, self.setup.speeds)

    @property
    def next_start(self) -> Array:
        """Where the next planned piece will begin [rad], shape (6,)."""
        waiting = self.queue.waiting
        return waiting[-1].path.joints[-1] if waiting else self.target

    def begin(self, plan: Plan, more: bool = False, ending: Ending = completion) -> None:
        """Take a planned piece of motion; it begins at once unless `more` follow."""
        self.health.clear()  # a new motion clears an error that was kept
        self._stream.forget()
        self.queue.add(plan, more, ending)
        if not more:
            self._yielded[:] = 0.0

    def stream(
        self, goal: Array, motion: Motion = Motion.STREAM, time_constant: float = 0.0, led: bool = False
    ) -> None:
        """Take one frame of a stream; a step too far is not followed but reported.

        Args:
            goal: Joints [rad], shape (6,).
            motion: What the state push calls it.
            time_constant: Of the smoothing [s].
            led: Whether the controller itself leads there, from anywhere.
        """
        if self.force_position is None:
            self._yielded[:] = 0.0
        stopping = self.halting or (self.motion in _STOPS and not self.at_rest)
        if not self.health.ready or self.health.tripped or self.busy or stopping:
            return
        if not self.setup.limits.contain(goal):
            self.health.error = TARGET_OVER_LIMIT
        elif not led and np.abs(goal - self.target).max() > LARGEST_STEP + np.abs(self._yielded).max():
            self.health.error = OVER_SPEED
        else:
            self.health.error, self.motion = 0, motion
            self._stream.take(goal, time_constant, self.setup.limits.speed if led else None)

    def stop(self, slow: bool = False) -> None:
        """Brake; a planned motion is given up."""
        self.motion = Motion.SLOW_STOP if slow else Motion.STOP
        self.queue.stop(slow)
        self._stream.forget()
        self.force_position = None

    def trip(self, trouble: JointTrouble) -> None:
        """Stop as fast as the joints can because of a fault of the arm; a planned motion is lost."""
        if not self.health.tripped:
            self.halt()
        for joint in trouble.stuck:  # it must not jump to where it should have been once it is free
            self.target[joint] = self.dynamics.positions[joint]
        self.health.note(trouble)

    def halt(self) -> None:
        """Stop as fast as the joints can, off any path."""
        self._ends += self.queue.abandon()
        self._stream.forget()
        self.force_position = None
        self.halting, self.motion = not self.dynamics.standing, Motion.STOP
        self.target = self.dynamics.joints

    def enable(self, joint: int, on: bool) -> None:
        """Switch a joint, from 0, on or off; off, its brake holds it and motions are lost."""
        if not on and self.health.enabled[joint]:
            self.halt()
        self.health.enabled[joint] = on
        self.target[joint] = self.dynamics.positions[joint]

    def set_power(self, on: bool) -> None:
        """Switch the joints on, or off: brakes hold them, motions are lost."""
        if not on and self.health.power:
            self.halt()
        self.health.power = on
        self.target = self.dynamics.joints

    def cut_power(self) -> None:
        """Lose power at once; nobody is told, and whatever was wrong is forgotten."""
        self.set_power(False)
        self._ends.clear()
        self.health.emergency = False
        self.health.clear()

    def stop_at_once(self, on: bool) -> None:
        """Let the brakes fall in until the emergency is over."""
        if on and not self.health.emergency:
            self.halt()
        self.health.emergency = on
        self.target = self.dynamics.joints

    def step(self) -> list[Settled]:
        """Advance by 5 ms; give the ends of planned motions."""
        trouble = joint_trouble(self.faults.at(Place.JOINTS), self.dynamics.positions, self.target)
        if trouble.error:
            self.trip(trouble)
        settled = [] if self.frozen else self._advance()
        self._move_joints(self.health.braked | trouble.stuck)
        self.T_base_flange = self.arm.kinematics.flange(self.dynamics.joints)
        contact = self.skin.step(self.T_base_head)
        self.sensor.measure(self.T_base_flange, contact.force, contact.torque)
        hit = collides(self.setup.collision_stage, contact.force)
        if hit and not self._hit:  # once: the arm must be able to leave
            self.trip(JointTrouble(error=COLLISION))
        self._hit = hit
        return settled

    def _move_joints(self, braked: frozenset[int]) -> None:
        """Let the joints follow the target, or stop."""
        held = dict.fromkeys(range(6), MOTOR) if self.halting else {}
        self.dynamics.step(self.target, STEP, held | dict.fromkeys(braked, BRAKE))
        if self.halting:
            self.target = self.dynamics.joints
            self.halting = not self.dynamics.standing

    def _advance(self) -> list[Settled]:
        """Move the target on."""
        ends, self._ends = self._ends, []
        joints, settled = self.queue.step(self.at_rest)
        if settled:
            self.motion = Motion.IDLE
            self.health.error = self.health.error if joints is not None else OVER_SPEED
        elif joints is not None:
            self._say_what_runs()
        elif (self.motion in _STOPS or not self._stream.alive) and self.at_rest:
            self.motion = Motion.IDLE
        if joints is None:
            joints = self._stream.step(self.target - self._yielded)
        self._yield()
        self.target = joints + self._yielded
        return ends + settled

    def _say_what_runs(self) -> None:
        if self.queue.paused:
            self.motion = Motion.PAUSE
        elif self.motion not in _STOPS and self.queue.current:
            self.motion = self.queue.current.motion

    def _yield(self) -> None:
        """Let force control lead away from the motion."""
        if self.force_position is not None and self.health.ready:
            speed = self.force_position.joint_speed(
                self.arm.kinematics, self.target, self.sensor.reading.zero
            )
            if self.setup.limits.contain(self.target + STEP * speed):
                self._yielded = self._yielded + STEP * speed
