"""The arm driver without ROS: approach, follow, retract, home, stop - each refused with a reason or done.

Calls that move plan first, in the caller's thread, and then hand a finished path to the control loop.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.arm import DrivenArm
from bathbot_scrub.arm.errors import ArmError, NotReadyError
from bathbot_scrub.arm.force_limits import ForceLimits, load_force_limits
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.controller.state_push import ArmSample
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from bathbot_scrub.rm65.motion.approach import Approach, Request, Touch
from bathbot_scrub.rm65.motion.arm_link import ArmLink
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from bathbot_scrub.rm65.motion.control_loop import ControlLoop
from bathbot_scrub.rm65.motion.controller_link import ControllerLink
from bathbot_scrub.rm65.motion.path_depth import Felt
from bathbot_scrub.rm65.motion.path_watch import LOOKS, PathWatch
from bathbot_scrub.rm65.motion.program_moves import ProgramMoves
from bathbot_scrub.rm65.motion.scrub_motion import ScrubMotion
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner
from bathbot_scrub.rm65.paths.path_runner import Pace
from bathbot_scrub.rm65.paths.surroundings import Surroundings
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.rm65.timing.beat import Ticker
from bathbot_scrub.rm65.timing.clock import MONOTONIC, Clock
from bathbot_scrub.segment.segment import Segment

Array = NDArray[np.float64]
_LEFT, _BRAKED = 2.0, 1.0  # [s] for the head to be off the skin, and for the arm to stand, in the end
_CLEARED = 0.2  # [s] within which a sample without the error must have come


class Snapshot(NamedTuple):
    """What the driver does now; the fields of bathbot_msgs/ArmState."""

    state: State
    reason: str
    connected: bool
    path_id: int
    segment_index: int
    segments_queued: int
    distance_along: float  # [m]
    path_done: bool
    force: float  # [N] filtered resultant, NaN when unknown
    force_threshold: float  # [N]
    period: float  # [s]
    period_deviation_p99: float  # [s]


class ArmDriver:
    """Drives one arm. Thread-safe; `approach` and `zero_force` block, the rest return at once."""

    def __init__(
        self,
        settings: DriverSettings,
        limits: ForceLimits,
        arm: DrivenArm,
        link: ArmLink,
        warn: Callable[[str], None] = lambda _: None,
        clock: Clock = MONOTONIC,
    ) -> None:
        """Prepare; `start` begins.

        Args:
            settings: Parameters.
            limits: How hard each region may be touched.
            arm: Kinematics, limits and shape.
            link: To the arm's controller; it is the driver's from now on.
            warn: Takes one line for the log.
            clock: Of everything here.
        """
        self.settings, self.limits, self.arm, self.link = settings, limits, arm, link
        self._clock, self._warn = clock, warn
        pace = Pace(settings.joint_speed, settings.joint_acceleration, 10.0 * settings.joint_acceleration)
        self.surroundings = Surroundings(self.arm, settings, clock)
        home = np.radians(settings.home_deg)
        self.planner = MotionPlanner(
            self.arm, home, pace, settings.joint_share, surroundings=self.surroundings
        )
        guard = ForceGuard(self.limits, settings.home_needs_consent)
        self.loop = ControlLoop(self.link, self.planner, guard, settings, warn, clock)
        self.watch, self._watching = PathWatch(self.loop, self.surroundings), None
        self._approach = Approach(self.loop, self.link, self.planner, self.limits, settings)
        self.moves = ProgramMoves(self.loop, self.planner, self.limits)
        self._scrub = ScrubMotion(self.loop, self.link, self.planner, self.limits, settings)

    def start(self) -> None:
        """Connect and guard, in threads of their own."""
        self.loop.thread.start()
        self._watching = Ticker(LOOKS, self.watch.look, self._warn)
        self.link.start(self.loop.connection_lost, self.loop.thread.wake)

    def approach(
        self,
        request: Request,
        canceled: Callable[[], bool] = lambda: False,
        progress: Callable[[float, float], None] = lambda remaining, force: None,
    ) -> Touch:
        """Go to a stand-off and straight on until skin is felt; see `Approach.run`."""
        touch = self._approach.run(request, canceled, progress, lambda: self._scrub.touched(None))
        self._scrub.touched(Felt(*touch))
        return touch

    def follow(self, segment: Segment) -> None:
        """Add a segment to the path; segment 0 starts a new one; see `ScrubMotion.follow`."""
        self._scrub.follow(segment)

    def refuse(self, path_id: int, index: int, why: str) -> None:
        """Take no more of a path whose segment `index` could not be read; see `ScrubMotion.refuse`."""
        self._scrub.refuse(path_id, index, why)

    def retract(self) -> None:
        """Leave along the outward normal at once; in FAULT too when only the force is in doubt.

        Asked again while it leaves, nothing changes.

        Raises:
            NotReadyError, UnreachableError: Joints or connection are in doubt; no way straight back. The arm
                goes on with what it did.
        """
        with self.loop.lock:
            self.loop.leave(self.loop.alarm())

    def home(self) -> None:
        """Fold the arm, from FREE, or from HOLD when the head is off the skin.

        Raises:
            NotReadyError, UnreachableError: With the reason.
        """
        path = self.planner.to_home(self.loop.standing(), self._approach.came)
        with self.loop.lock:
            self.loop.guard.begin_approach(self.limits.gentlest(), "going home")
            patch = self.arm.head(path.joints[:1])[:, :3, 3]
            self.loop.begin(path, self.planner.joint_pace, MotionKind.HOME, patch)
        self._approach.came = (
            None  # asked again, from home or half-way, the arm must not go back to the person
        )

    def stop(self) -> None:
        """Brake and give the motion up."""
        with self.loop.lock:
            self.loop.guard.stop("stopped")
            self.loop.motion.brake()
            self.moves.give_up(self._clock())
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
        """Go on after a pause, allow the next motion, leave FAULT, or vouch for an untouched head.

        A paused motion goes on only where the rest of its way is free. Blocks while errors are cleared.

        Raises:
            ArmError: When none applies, or the cause is still there.
        """
        loop = self.loop
        if _in_error(self.link.sample):
            self.link.clear_errors()
            deadline = self._clock() + _CLEARED
            while _in_error(self.link.sample) and self._clock() < deadline:
                self._clock.sleep(0.005)
        self.watch.check_paused()
        with loop.lock:
            if loop.guard.state is State.FAULT and not loop.moving:
                loop.forget()
            try:
                if loop.guard.resume(loop.alarm()):
                    loop.resume()
            except NotReadyError:
                if loop.alarm().doubtful or not self.link.zeroing.allow():
                    raise

    def zero_force(self) -> float:
        """Zero the sensor; give what remains [N]. Blocks for a fifth of a second.

        Raises:
            NotReadyError: While moving or touching, or when too much remains.
            ArmError: When the controller refuses.
        """
        with self.loop.lock:
            if self.loop.guard.just_started:
                raise NotReadyError(self.loop.guard.reason)
            if self.loop.moving or self.loop.guard.touching:
                raise NotReadyError("zeroing needs an arm at rest off the skin; retract or stop first")
        return self.link.zeroing.run(self.limits)

    def snapshot(self) -> Snapshot:
        """What the driver does now."""
        loop, wrench = self.loop, self.link.wrench
        with loop.lock:
            guard, progress = loop.guard, self._scrub.progress()
            state, reason, threshold = guard.state, guard.waiting or guard.reason, guard.region.retract
            if state is State.CONTACT and self._scrub.refusal:
                reason = self._scrub.refusal
            elif state is State.CONTACT and progress.at_end:
                reason = "path done" if progress.done else f"waits for segments: {loop.awaits}"
        reading = self.link.sense(self._clock()).reading
        fresh = reading.age <= self.settings.stale_after
        connected = self.link.connected and fresh and loop.first.decided
        if not connected and (guard.just_started or not reason):
            reason = self.link.trouble or (
                "looks where the arm stands" if fresh else "no state from the controller"
            )
        return Snapshot(
            state,
            reason,
            connected,
            progress.path_id,
            progress.segment_index,
            progress.segments_queued,
            progress.distance_along,
            progress.done,
            wrench.force if wrench else math.nan,
            threshold,
            loop.log.statistics.period,
            loop.log.statistics.p99(),
        )

    def close(self) -> None:
        """Leave the skin, brake, and end everything; takes a few seconds at most."""
        self._leave_at_last()
        self.stop()
        with self.loop.lock:
            self.loop.lock.wait_for(lambda: not self.loop.moving, _BRAKED)
        if self._watching is not None:
            self._watching.close()
        self.loop.thread.close()
        self.link.close()

    def _leave_at_last(self) -> None:
        """Take the head off the skin if it may touch, or say why it stays there."""
        loop, told = self.loop, ""
        with loop.lock:
            if not loop.guard.touching:
                return
            try:
                loop.leave(loop.alarm())
                loop.lock.wait_for(lambda: loop.guard.state is not State.RETRACTING, _LEFT)
            except ArmError as error:
                told = str(error)
            if loop.guard.touching:
                self._warn(f"the head may still be on the skin: {told or loop.guard.reason}")


def _in_error(sample: ArmSample | None) -> bool:
    """Whether the controller tells of an error."""
    return sample is not None and bool(sample.errors or any(sample.joint_errors))


def rm65_driver(settings: DriverSettings, warn: Callable[[str], None] = lambda _: None) -> ArmDriver:
    """The driver of the RM65 that the settings name.

    Raises:
        ArmError: On a bad limits file or a UDP port that is taken.
    """
    limits = load_force_limits(settings.force_limits)
    driver = ArmDriver(settings, limits, RM65(settings.variant), ControllerLink(settings, warn), warn)
    driver.start()
    return driver
