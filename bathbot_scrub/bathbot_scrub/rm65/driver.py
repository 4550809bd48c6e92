"""The arm driver without ROS: approach, follow, retract, home, stop - each refused with a reason or done.

Calls that move plan first, in the caller's thread, and then hand a finished path to the control loop.
"""

import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.approach import Approach, Request, Touch
from bathbot_scrub.rm65.control_loop import ControlLoop
from bathbot_scrub.rm65.driver_settings import DriverSettings
from bathbot_scrub.rm65.errors import ArmError, NotReadyError
from bathbot_scrub.rm65.force_guard import ForceGuard
from bathbot_scrub.rm65.force_limits import load_force_limits
from bathbot_scrub.rm65.guard_states import State
from bathbot_scrub.rm65.inverse_kinematics import check_poses
from bathbot_scrub.rm65.kinematics import Kinematics
from bathbot_scrub.rm65.link import Link
from bathbot_scrub.rm65.motion import Planner, line_pace
from bathbot_scrub.rm65.motion_kind import Kind
from bathbot_scrub.rm65.path_runner import Pace
from bathbot_scrub.rm65.segment_queue import ScrubPath, Segment
from bathbot_scrub.rm65.snapshot import Snapshot

Array = NDArray[np.float64]
_CLEARED = 0.2  # [s] within which a sample without the error must have come


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
        pace = Pace(settings.joint_speed, settings.joint_acceleration, 10.0 * settings.joint_acceleration)
        self.planner = Planner(self.kinematics, np.radians(settings.home_deg), pace, settings.joint_share)
        self.link = Link(settings, warn)
        guard = ForceGuard(self.limits, settings.home_needs_consent)
        self.loop = ControlLoop(self.link, self.planner, guard, settings, warn)
        self._approach = Approach(self.loop, self.link, self.planner, self.limits, settings)
        self._path: ScrubPath | None = None
        self._refusal = ""  # why the newest segment was not taken
        self.loop.start()
        self.link.start(self.loop.connection_lost, self.loop.wake)

    def approach(
        self,
        request: Request,
        canceled: Callable[[], bool] = lambda: False,
        progress: Callable[[float, float], None] = lambda remaining, force: None,
    ) -> Touch:
        """Go to a stand-off and straight on until skin is felt; see `Approach.run`."""
        return self._approach.run(request, canceled, progress)

    def follow(self, segment: Segment) -> None:
        """Add a segment to the path; segment 0 starts a new one.

        Raises:
            NotReadyError: Not in contact, out of order, or the queue is full.
            UnreachableError, InvalidPoseError: The segment is refused as a whole.
        """
        try:
            self._append(segment)
            self._refusal = ""
        except ArmError as error:
            self._refusal = f"segment {segment.index} was refused: {error}"
            raise

    def retract(self) -> None:
        """Leave along the outward normal at once; in FAULT too when only the force is in doubt.

        Raises:
            NotReadyError, UnreachableError: Joints or connection are in doubt; no way straight back.
        """
        with self.loop.lock:
            alarm = self.loop.alarm()
            self.loop.where()
            self.loop.guard.begin_retract(alarm)
            try:
                self.loop.leave()
            except ArmError as error:
                self.loop.guard.fault(f"cannot leave: {error}")
                raise

    def home(self) -> None:
        """Fold the arm, from FREE, or from HOLD when the head is off the skin.

        Raises:
            NotReadyError, UnreachableError: With the reason.
        """
        path = self.planner.to_home(self.loop.standing(), self._approach.came)
        with self.loop.lock:
            self.loop.guard.begin_approach(self.limits.gentlest(), "going home")
            self.loop.begin(path, self.planner.joint_pace, Kind.HOME)
        self._approach.came = (
            None  # asked again, from home or half-way, the arm must not go back to the person
        )

    def stop(self) -> None:
        """Brake and give the motion up."""
        with self.loop.lock:
            self.loop.guard.stop("stopped")
            self.loop.motion.brake()
            self.loop.lock.notify_all()

    def pause(self) -> None:
        """Brake and wait for `resume`.

        Raises:
            NotReadyError: When there is nothing to pause.
        """
        with self.loop.lock:
            self.loop.guard.pause()
            self.loop.motion.brake()

    def resume(self) -> None:
        """Go on after a pause, allow the next motion, or leave FAULT; blocks while errors are cleared.

        Raises:
            ArmError: When none applies, or the cause is still there.
        """
        loop, sample = self.loop, self.link.sample
        if sample is not None and (sample.errors or any(sample.joint_errors)):
            self.link.clear_errors()
            deadline = time.monotonic() + _CLEARED
            while self.link.sample is sample and time.monotonic() < deadline:
                time.sleep(0.005)
        with loop.lock:
            if loop.guard.state is State.FAULT and not loop.guard.moving:
                loop.forget()
            if loop.guard.resume(loop.alarm()):
                loop.resume()

    def zero_force(self) -> float:
        """Zero the sensor; give what remains [N]. Blocks for a fifth of a second.

        Raises:
            NotReadyError: While moving or touching, or when too much remains.
            ArmError: When the controller refuses.
        """
        with self.loop.lock:
            if self.loop.guard.moving or self.loop.guard.touching:
                raise NotReadyError("zeroing needs an arm at rest off the skin; retract or stop first")
        return self.link.zero_force(self.limits)

    def snapshot(self) -> Snapshot:
        """What the driver does now."""
        loop, path, wrench = self.loop, self._path, self.link.wrench
        index, queued, along, done = 0, 0, 0.0, False
        with loop.lock:
            guard, runner = loop.guard, loop.motion.runner
            state, reason, threshold = guard.state, guard.waiting or guard.reason, guard.threshold
            if path is not None and runner is not None and loop.motion.kind is Kind.SCRUB:
                index, queued = path.segment_at(runner.length), path.queued_at(runner.length)
                along, done = path.travelled_at(runner.length), path.finished and runner.at_end
                if state is State.CONTACT and runner.at_end:
                    reason = "path done" if done else self._refusal or "waits for segments"
        reading = self.link.sense().reading
        connected = self.link.connected and reading.age <= self.settings.stale_after
        if not (reason or connected):
            reason = self.link.trouble or "no state from the controller"
        return Snapshot(
            state,
            reason,
            connected,
            path.path_id if path else 0,
            index,
            queued,
            along,
            done,
            wrench.force if wrench else math.nan,
            threshold,
            loop.statistics.period,
            loop.statistics.p99(),
        )

    def close(self) -> None:
        """Brake, and end everything."""
        self.stop()
        with self.loop.lock:
            self.loop.lock.wait_for(lambda: not self.loop.guard.moving, 1.0)
        self.loop.close()
        self.link.close()

    def _append(self, segment: Segment) -> None:
        path, loop = self._path, self.loop
        if path is None or path.path_id != segment.path_id or segment.index == 0:
            self._start_path(segment)
            return
        with loop.lock:
            if path.queued_at(self._length(path)) >= self.settings.queue_length:
                raise NotReadyError(f"{self.settings.queue_length} segments wait already; send fewer ahead")
        longer = path.extend(segment)
        with loop.lock:
            loop.extend(longer)
            loop.path_open = not segment.last

    def _start_path(self, segment: Segment) -> None:
        region, loop = self.limits.region(segment.region), self.loop
        self._require_contact()
        start = loop.where()
        first = check_poses(segment.T_base_heads)
        if first.ndim != 3 or not len(first):
            raise NotReadyError(f"path {segment.path_id} begins without poses; send some")
        lead_in = self.planner.lead_in(
            self.kinematics.head(start), first[0], self.settings.lift, self.settings.max_lead_in
        )
        path = ScrubPath(segment, self.planner, start, lead_in, self.settings.max_scrub_speed)
        with loop.lock:
            self._require_contact()
            loop.guard.region = region
            loop.begin(
                path.path,
                line_pace(self.settings.max_scrub_speed, self.settings.scrub_acceleration),
                Kind.SCRUB,
            )
            self._path, loop.path_open = path, not segment.last

    def _require_contact(self) -> None:
        guard = self.loop.guard
        if guard.state is not State.CONTACT:
            raise NotReadyError(
                f"a path begins in contact, but the arm is in {guard.state.name} ({guard.reason or 'idle'}); "
                "approach first"
            )
        if guard.moving:
            raise NotReadyError("the arm still follows another path; wait until it stands, or stop it")

    def _length(self, path: ScrubPath) -> float:
        runner = self.loop.motion.runner
        if runner is None or self.loop.motion.kind is not Kind.SCRUB:
            guard = self.loop.guard
            raise NotReadyError(
                f"path {path.path_id} was given up: {guard.reason or guard.state.name}; begin a new one"
            )
        return runner.length
