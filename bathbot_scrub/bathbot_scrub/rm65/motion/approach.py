"""The approach: zero the force sensor, go to a stand-off, zero again, then straight on until skin is felt."""

import math
import threading
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.node.parameters import declared
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.errors import (
    ArmError,
    CanceledError,
    ForceLimitError,
    InvalidPoseError,
    NoContactError,
    NotReadyError,
    UnreachableError,
)
from bathbot_scrub.arm.force_limits import ForceLimits
from bathbot_scrub.arm.states import Cause, Reaction, State
from bathbot_scrub.rm65.arm.inverse_kinematics import check_poses
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from bathbot_scrub.rm65.motion.arm_link import ArmLink
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from bathbot_scrub.rm65.motion.control_loop import ControlLoop
from bathbot_scrub.rm65.paths.joint_path import JointPath
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner, line_pace
from bathbot_scrub.rm65.settings import LEAST_STANDOFF, DriverSettings

Array = NDArray[np.float64]
_MOTION_TIMEOUT = 60.0  # [s] no single motion lasts longer
_PATIENCE = 3.0  # [s] for data to be steady before a motion begins
_ACCELERATION = 0.3  # [m/s^2] of the straight part
_SHORTER = (1.0, 0.7, 0.4)  # of the stand-off, where the arm cannot fold as far as asked


class Touch(NamedTuple):
    """Where and how hard skin was felt."""

    T_base_head: Array  # (4, 4)
    force: float  # [N]


class Request(NamedTuple):
    """What an approach is asked for."""

    T_base_target: ArrayLike  # head pose on the skin, z into it, (4, 4)
    region: str  # class name; chooses the limits
    standoff: float = 0.0  # [m]; 0: the setting
    speed: float = 0.0  # of the straight part [m/s]; 0: the setting


class Approach:
    """Runs one approach at a time, in the caller's thread."""

    def __init__(
        self,
        loop: ControlLoop,
        link: ArmLink,
        planner: MotionPlanner,
        limits: ForceLimits,
        settings: DriverSettings,
    ) -> None:
        """Work with these parts of a driver."""
        self._loop, self._link, self._planner = loop, link, planner
        self._limits, self._settings = limits, settings
        self._one = threading.Lock()
        self.came: JointPath | None = None  # the way to the stand-off, until the arm goes elsewhere

    def run(
        self,
        request: Request,
        canceled: Callable[[], bool] = lambda: False,
        progress: Callable[[float, float], None] = lambda remaining, force: None,
        sets_out: Callable[[], None] = lambda: None,
    ) -> Touch:
        """Approach; blocks until skin is felt.

        Args:
            request: Where and how.
            canceled: Asked now and then.
            progress: Told the remaining distance [m] and the force [N].
            sets_out: Called once it is granted, before anything moves.

        Raises:
            InvalidPoseError, UnreachableError, NotReadyError, NoContactError, ForceLimitError, CanceledError.
        """
        target, limits = check_poses(request.T_base_target), self._limits.region(request.region)
        # what was asked for is bound as the settings are: the way to a stand-off on the skin is a fast one
        standoff = _chosen("standoff", request.standoff, self._settings.standoff)
        speed = _chosen("approach_speed", request.speed, self._settings.approach_speed)
        if not self._one.acquire(blocking=False):
            raise NotReadyError("another approach is on its way; cancel it first")
        try:
            with self._loop.lock:  # what passes by itself is no reason to refuse
                self._loop.lock.wait_for(lambda: self._loop.alarm().reaction is not Reaction.WAIT, _PATIENCE)
            way, line = self._plan(target, standoff, speed)
            with self._loop.lock:
                self._loop.guard.begin_approach(limits, f"on the way to {request.region}")
            self.came = None
            sets_out()
            self._zero()
            self._move(way, MotionKind.TRANSIT, self._planner.joint_pace, target, canceled, progress)
            self.came = way
            self._zero()
            self._move(line, MotionKind.SEEK, line_pace(speed, _ACCELERATION), target, canceled, progress)
            return self._felt()
        finally:
            self._one.release()

    def _plan(self, target: Array, standoff: float, speed: float) -> tuple[JointPath, JointPath]:
        """The way to the stand-off and the straight part, before anything moves."""
        start, first = self._loop.standing(), None
        for share in _SHORTER:
            try:
                return self._planner.to_touch(
                    start, target, max(share * standoff, LEAST_STANDOFF), self._settings.max_extra, speed
                )
            except UnreachableError as error:
                first = first or error
        raise first or UnreachableError("no way to the target")

    def _zero(self) -> None:
        """Zero the sensor; when that fails the approach is over and the arm holds."""
        try:
            self._link.zeroing.run(self._limits)
        except ArmError as error:
            with self._loop.lock:
                self._loop.guard.stop(str(error))
            raise

    def _move(
        self,
        path: JointPath,
        kind: MotionKind,
        pace,
        target: Array,
        canceled: Callable[[], bool],
        progress: Callable[[float, float], None],
    ) -> None:
        """Begin a motion and wait for its end, pauses included."""
        loop, left = self._loop, _MOTION_TIMEOUT
        with loop.lock:
            if loop.guard.state is not State.APPROACH:
                raise _why(loop.guard)
            if kind is MotionKind.SEEK:
                loop.guard.begin_seeking()
            loop.begin(path, pace, kind, target[None, :3, 3])
        while True:
            with loop.lock:
                over = loop.lock.wait_for(lambda: not _under_way(loop), 0.1)
                command, state = loop.motion.command, loop.guard.state
                if over and (state is State.APPROACH or kind is MotionKind.SEEK):
                    return
                if over:
                    raise _why(loop.guard)
                left -= 0.1
                if canceled() or left < 0.0:
                    loop.guard.stop("the approach was canceled")
                    loop.motion.brake()
                    raise CanceledError(
                        "the approach was canceled" if left >= 0.0 else "the approach took too long"
                    )
            if command is not None:
                head = self._planner.arm.head(command)
                progress(float(target[:3, 2] @ (target[:3, 3] - head[:3, 3])), self._force())

    def _felt(self) -> Touch:
        with self._loop.lock:
            if self._loop.guard.state is not State.CONTACT or self._loop.motion.command is None:
                raise _why(self._loop.guard)
            return Touch(self._planner.arm.head(self._loop.motion.command), self._force())

    def _force(self) -> float:
        wrench = self._link.wrench
        return math.nan if wrench is None else wrench.force


def _under_way(loop: ControlLoop) -> bool:
    """Whether the motion goes on, or will by itself or when someone resumes."""
    return bool(loop.moving or loop.guard.paused or loop.guard.waiting)


def _why(guard: ForceGuard) -> ArmError:
    """The error that tells why an approach ended without contact."""
    if guard.cause is Cause.NO_CONTACT:
        return NoContactError(f"{guard.reason}; was the target right, or has the person moved?")
    if guard.cause is Cause.FORCE:
        return ForceLimitError(guard.reason)
    if guard.cause is Cause.DATA:
        return NotReadyError(guard.reason)
    return CanceledError(guard.reason or f"the arm went to {guard.state.name}")


def _chosen(name: str, value: float, default: float) -> float:
    rule = declared(DriverSettings)[name]
    if not rule.allows(value or default):
        raise InvalidPoseError(f"{name} {rule.rule}, got {value}; 0 takes the setting")
    return value or default
