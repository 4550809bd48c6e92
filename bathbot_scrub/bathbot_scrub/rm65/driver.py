"""The arm driver without ROS: approach, follow, retract, home, stop - each refused with a reason or done.

Calls that move plan first, in the caller's thread, and then hand a finished path to the control loop.
"""

import math
import threading
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.control_loop import ControlLoop, Kind, Retract
from bathbot_scrub.rm65.driver_settings import DriverSettings
from bathbot_scrub.rm65.errors import (
    ArmError,
    CanceledError,
    ForceLimitError,
    NoContactError,
    NotReadyError,
    UnreachableError,
)
from bathbot_scrub.rm65.force_guard import ForceGuard, State
from bathbot_scrub.rm65.force_limits import load_force_limits
from bathbot_scrub.rm65.inverse_kinematics import check_poses
from bathbot_scrub.rm65.kinematics import Kinematics
from bathbot_scrub.rm65.link import Link
from bathbot_scrub.rm65.motion import Planner, line_pace, retreated
from bathbot_scrub.rm65.path_runner import Pace
from bathbot_scrub.rm65.segment_queue import ScrubPath, Segment

Array = NDArray[np.float64]
_MOTION_TIMEOUT = 60.0  # [s] no single motion lasts longer
_APPROACH_ACCELERATION = 0.3  # [m/s^2]


class Touch(NamedTuple):
    """Where and how skin was felt."""

    T_base_head: Array  # (4, 4)
    force: float        # [N]


class Snapshot(NamedTuple):
    """What the driver does now."""

    state: State
    reason: str
    connected: bool
    path_id: int
    segment_index: int
    segments_queued: int
    distance_along: float  # [m]
    path_done: bool
    force: float           # [N] filtered resultant, NaN when unknown
    force_threshold: float  # [N]
    period: float          # [s]
    period_deviation_p99: float  # [s]


class ArmDriver:
    """Drives one arm. Thread-safe; `approach` and `zero_force` block, the rest return at once."""

    def __init__(self, settings: DriverSettings, warn: Callable[[str], None] = lambda _: None) -> None:
        """Start to connect and to guard.

        Args:
            settings: Parameters.
            warn: Takes one line for the log.

        Raises:
            ArmError: On a bad limits file or a UDP port that is taken.
        """
        self.settings = settings
        self.kinematics = Kinematics(settings.variant)
        self.limits = load_force_limits(settings.force_limits)
        self.home_joints = np.radians(settings.home_deg)
        self.joint_pace = Pace(settings.joint_speed, settings.joint_acceleration, 10.0 * settings.joint_acceleration)
        self.planner = Planner(self.kinematics, self.home_joints, self.joint_pace, settings.joint_share)
        self._path: ScrubPath | None = None
        self._approaching = threading.Lock()
        self.loop: ControlLoop
        self.link = Link(settings.host, settings.port, settings.udp_port, settings.variant, settings.force_cutoff,
                         warn, lambda: self._lost())
        self.loop = ControlLoop(
            self.link.client, self.planner, ForceGuard(self.limits, settings.stale_after), self.link.sense,
            Retract(settings.retract_distance, settings.retract_speed), 1.0 / settings.rate, warn)
        self.loop.start()

    def approach(self, T_base_target: ArrayLike, region: str, standoff: float = 0.0, speed: float = 0.0,
                 canceled: Callable[[], bool] = lambda: False,
                 progress: Callable[[float, float], None] = lambda remaining, force: None) -> Touch:
        """Go to a stand-off before the target and on along its z axis until skin is felt. Blocks.

        Args:
            T_base_target: Head pose on the skin, z into it, (4, 4).
            region: Class name; chooses the limits.
            standoff: [m]; 0: the setting.
            speed: Of the straight part [m/s]; 0: the setting.
            canceled: Asked now and then.
            progress: Told the remaining distance [m] and the force [N].

        Raises:
            InvalidPoseError, UnreachableError, NotReadyError, NoContactError, ForceLimitError, CanceledError.
        """
        target, limits = check_poses(T_base_target), self.limits.region(region)
        standoff, speed = _positive(standoff, self.settings.standoff), _positive(speed, self.settings.approach_speed)
        speed = min(speed, 2.0 * self.settings.approach_speed)  # the guard's reaction was judged at this
        if not self._approaching.acquire(blocking=False):
            raise NotReadyError("another approach is on its way; cancel it first")
        try:
            start = self._standing()
            way = self.planner.to_pose(start, retreated(target, standoff))
            line = self.planner.line(way.joints[-1], standoff + self.settings.max_extra, speed)
            with self.loop.lock:
                self.loop.guard.begin_approach(limits, f"on the way to {region}")
            self._guarded(self._zero)
            with self.loop.lock:
                self._require_approach()
                self.loop.begin(way, self.joint_pace, Kind.TRANSIT)
            self._wait(target, canceled, progress)
            self._guarded(self._zero)
            with self.loop.lock:
                self._require_approach()
                self.loop.guard.begin_seeking()
                self.loop.begin(line, line_pace(speed, _APPROACH_ACCELERATION), Kind.SEEK)
            self._wait(target, canceled, progress)
            return self._felt()
        finally:
            self._approaching.release()

    def follow(self, segment: Segment) -> None:
        """Add a segment to the path; the first of a new path starts it.

        Raises:
            NotReadyError: Not in contact, out of order, or the queue is full.
            UnreachableError, InvalidPoseError: The segment is refused as a whole.
        """
        path, loop = self._path, self.loop
        if path is None or path.path_id != segment.path_id or segment.index == 0:
            self._start_path(segment)
            return
        with loop.lock:
            runner = loop.runner
            if runner is None or loop.kind is not Kind.SCRUB:
                raise NotReadyError(f"path {segment.path_id} was given up: {loop.guard.reason or loop.guard.state.name}")
            if path.queued_at(runner.length) >= self.settings.queue_length:
                raise NotReadyError(f"{self.settings.queue_length} segments wait already; send fewer ahead")
        longer = path.extend(segment)
        with loop.lock:
            loop.extend(longer)

    def retract(self) -> None:
        """Leave along the outward normal at once.

        Raises:
            NotReadyError: In FAULT, or without a pose to leave from.
        """
        sensed = self.link.sense()
        with self.loop.lock:
            if self.loop.command is None:
                self._standing()
            self.loop.guard.begin_retract()
            self.loop.leave(sensed.joints)

    def home(self) -> None:
        """Fold the arm, from FREE, or from HOLD when the head is off the skin.

        Raises:
            NotReadyError, UnreachableError: With the reason.
        """
        path = self.planner.to_home(self._standing())
        with self.loop.lock:
            self.loop.guard.begin_approach(self.limits.gentlest(), "going home")
            self.loop.begin(path, self.joint_pace, Kind.HOME)

    def stop(self) -> None:
        """Brake and give the motion up."""
        with self.loop.lock:
            self.loop.guard.stop("stopped")
            self.loop.brake()
            self.loop.lock.notify_all()

    def pause(self) -> None:
        """Brake and wait for `resume`.

        Raises:
            NotReadyError: When there is nothing to pause.
        """
        with self.loop.lock:
            self.loop.guard.pause()
            self.loop.brake()

    def resume(self) -> None:
        """Go on after a pause, or leave FAULT when its cause is gone.

        Raises:
            NotReadyError: When neither applies.
        """
        with self.loop.lock:
            if self.loop.guard.resume(self.link.sense().reading):
                self.loop.resume()

    def zero_force(self) -> float:
        """Zero the sensor; give what remains [N]. Blocks for a fifth of a second.

        Raises:
            NotReadyError: While moving or touching.
            ArmError: When the controller refuses or too much remains.
        """
        with self.loop.lock:
            if self.loop.guard.moving or self.loop.guard.touching:
                raise NotReadyError("zeroing needs an arm at rest off the skin; retract or stop first")
        return self._zero()

    def snapshot(self) -> Snapshot:
        """What the driver does now."""
        loop, path, wrench = self.loop, self._path, self.link.wrench
        with loop.lock:
            guard, runner = loop.guard, loop.runner
            length = runner.length if runner is not None and loop.kind is Kind.SCRUB else None
            at_end = runner is not None and loop.kind is Kind.SCRUB and runner.at_end
            state, reason, threshold = guard.state, guard.reason, guard.threshold
        index, queued, along = 0, 0, 0.0
        if path is not None and length is not None:
            index, queued, along = path.segment_at(length), path.queued_at(length), max(length - path.lead_in, 0.0)
        fresh = self.link.sense().reading.age <= self.settings.stale_after
        if not reason and not (self.link.connected and fresh):
            reason = self.link.trouble or "no state from the controller"
        if not reason and state is State.CONTACT and path is not None and at_end:
            reason = "path done" if path.finished else "waits for segments"
        return Snapshot(state, reason, self.link.connected and fresh, path.path_id if path else 0, index, queued, along,
                        bool(path and path.finished and at_end), wrench.force if wrench else math.nan, threshold,
                        loop.statistics.period, loop.statistics.p99())

    def close(self) -> None:
        """Brake, and end everything."""
        self.stop()
        with self.loop.lock:
            self.loop.lock.wait_for(lambda: not self.loop.guard.moving, 1.0)
        self.loop.close()
        self.link.close()

    def _start_path(self, segment: Segment) -> None:
        region, loop = self.limits.region(segment.region), self.loop
        with loop.lock:
            if loop.guard.state is not State.CONTACT:
                raise NotReadyError(f"a path begins in contact, but the arm is in {loop.guard.state.name}; approach first")
            if loop.guard.moving:
                raise NotReadyError(f"path {segment.path_id} must wait until the arm stands still")
            start = self._standing()
        here = self.kinematics.head(start)
        first = check_poses(segment.T_base_heads)[0]
        lead_in = self.planner.lead_in(here, first, self.settings.lift, self.settings.max_lead_in)
        path = ScrubPath(segment, self.planner, start, lead_in, self.settings.max_scrub_speed)
        with loop.lock:
            if loop.guard.state is not State.CONTACT:
                raise NotReadyError(f"the arm is in {loop.guard.state.name}: {loop.guard.reason}")
            loop.guard.region = region
            loop.begin(path.path, line_pace(self.settings.max_scrub_speed, self.settings.scrub_acceleration), Kind.SCRUB)
            self._path = path

    def _standing(self) -> Array:
        """Joints from which a motion begins: those last commanded, else those measured just now."""
        with self.loop.lock:
            if self.loop.command is not None:
                return self.loop.command
        sensed = self.link.sense()
        if not (sensed.reading.connected and sensed.reading.age <= self.settings.stale_after):
            raise NotReadyError(f"no recent state from the controller: {self.link.trouble or 'UDP push is silent'}")
        return sensed.joints

    def _zero(self) -> float:
        residual = self.link.zero_force()
        if not residual <= self.limits.zero_residual:
            raise NotReadyError(f"{residual:.2f} N remain after zeroing, more than {self.limits.zero_residual} N; "
                                "is the arm at rest and free?")
        return residual

    def _guarded(self, action: Callable[[], float]) -> None:
        """Run a step of the approach; on failure the approach is over and says so."""
        try:
            action()
        except ArmError as error:
            with self.loop.lock:
                self.loop.guard.stop(str(error))
            raise

    def _require_approach(self) -> None:
        guard = self.loop.guard
        if guard.state is not State.APPROACH:
            raise _why(guard)

    def _wait(self, target: Array, canceled: Callable[[], bool], progress: Callable[[float, float], None]) -> None:
        """Wait until the motion of an approach is over; pauses included."""
        loop, left = self.loop, _MOTION_TIMEOUT
        while True:
            with loop.lock:
                loop.lock.wait_for(lambda: not loop.guard.moving and not loop.guard.paused, 0.1)
                over = not loop.guard.moving and not loop.guard.paused
                command = loop.command
            if over:
                return
            left -= 0.1
            if canceled() or left < 0.0:
                self.stop()
                raise CanceledError("the approach was canceled" if left >= 0.0 else "the approach took too long")
            if command is not None:
                head = self.kinematics.head(command)
                force = self.link.wrench.force if self.link.wrench else math.nan
                progress(float(target[:3, 2] @ (target[:3, 3] - head[:3, 3])), force)

    def _felt(self) -> Touch:
        with self.loop.lock:
            if self.loop.guard.state is not State.CONTACT:
                raise _why(self.loop.guard)
            command = self.loop.command
        return Touch(self.kinematics.head(command), self.link.wrench.force if self.link.wrench else math.nan)

    def _lost(self) -> None:
        if hasattr(self, "loop"):
            with self.loop.lock:
                if self.loop.guard.moving or self.loop.guard.touching:
                    self.loop.guard.fault("connection to the controller lost")
            self.loop.forget()


def _why(guard: ForceGuard) -> ArmError:
    """The error that tells why an approach ended without contact."""
    if "nothing felt" in guard.reason:
        return NoContactError(f"{guard.reason}; was the target right, or has the person moved?")
    if "retract" in guard.reason or "stopped: " in guard.reason:
        return ForceLimitError(guard.reason)
    return CanceledError(guard.reason or f"the arm went to {guard.state.name}")


def _positive(value: float, default: float) -> float:
    if not (math.isfinite(value) and value >= 0.0):
        raise UnreachableError(f"standoff and speed must be finite and not negative, got {value}")
    return value or default
