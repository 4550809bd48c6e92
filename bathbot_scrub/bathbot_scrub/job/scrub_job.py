"""One scrub: a thread that plans segments a few ahead of the arm and watches arm and skin (Fig. 7).

The paper's two threads and FIFO: this thread plans, the arm's driver drains its queue. The queue is
bounded: a segment is sent only when the arm holds fewer than `ahead`, so each is planned on a
surface as new as can be.
"""

import threading
import time
from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

from bathbot_depthcorr.errors import BathbotError

from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.states import State
from bathbot_scrub.errors import (
    ArmLeftError,
    ArmStoppedError,
    NotReadyError,
    OutOfReachError,
    ScrubCanceledError,
    SegmentRefusedError,
    SurfaceError,
    TargetLostError,
)
from bathbot_scrub.path.planner import PathPlanner
from bathbot_scrub.path.surface_map import Sighting
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from bathbot_scrub.segment.segment import Segment, is_refusal

_TICK = 0.05  # [s] between looks at clock and arm when nothing arrives


class Code(IntEnum):
    """Error codes of action/Scrub."""

    NONE = 0
    NO_SURFACE = 1
    UNREACHABLE = 2
    FORCE_LIMIT = 3
    ARM_STOPPED = 4
    TARGET_LOST = 5
    NOT_READY = 6
    CANCELED = 7


class ArmReport(NamedTuple):
    """What the arm says of itself; fields as in bathbot_msgs/ArmState."""

    state: State
    reason: str
    path_id: int
    segment_index: int
    segments_queued: int
    distance_along: float
    path_done: bool

    def segment_on(self, path_id: int) -> int:
        """Index of the segment under the head on a path; 0 while it is on another."""
        return self.segment_index if self.path_id == path_id else 0


class Outcome(NamedTuple):
    """How a scrub ended.

    Attributes:
        code: What kept it from success.
        message: In plain words; empty where all of the path was scrubbed.
        segments: Sent to the arm.
        length: Of path followed [m].
    """

    code: Code
    message: str
    segments: int
    length: float

    @property
    def broke_off(self) -> bool:
        """Whether it ended while the arm scrubs on: it must not use up its queue."""
        return self.segments > 0 and self.code in (Code.TARGET_LOST, Code.UNREACHABLE, Code.CANCELED)

    @property
    def harmless(self) -> bool:
        """Whether it did not succeed for a reason that is no trouble: it was canceled, or asked too early."""
        return self.code in (Code.CANCELED, Code.NOT_READY)

    def told(self, region: str) -> str:
        """How the scrub of a region ended, in one line."""
        if self.code is Code.NONE:
            done = f"scrubbed {self.length:.2f} m of {region} in {self.segments} segments"
            return f"{done}; {self.message}" if self.message else done
        return f"{region}: {self.message}"


class ScrubJob:
    """Runs one path from the first segment to its end."""

    def __init__(
        self,
        path_id: int,
        plan: Callable[[], PathPlanner],
        send: Callable[[Segment, float, float], None],
        done: Callable[[Outcome], None],
        clock: Callable[[], float],
        settings: ScrubPlannerSettings,
    ) -> None:
        """Keep what the thread needs; `start` runs it.

        Args:
            path_id: Of all segments of this path.
            plan: Chooses the path; called once, in the thread.
            send: Takes each segment, the time its planning took [s], and the share of the path given out so
                far, 0..1; called in the thread.
            done: Called once, at the end, in the thread.
            clock: Time [s] on the scale of the surfaces' stamps.
            settings: Of the planner.
        """
        self.path_id = path_id
        self._plan, self._send, self._done, self._clock, self._settings = plan, send, done, clock, settings
        self._news = threading.Condition()
        self._sighting: Sighting | None = None
        self._arm: ArmReport | None = None
        self._unheard = 0.0  # [s] of listening since the arm said something
        self._canceled = False
        self._sent, self._length, self._moved = 0, 0.0, time.monotonic()
        self._thread = threading.Thread(target=self._run, name="scrub", daemon=True)

    def start(self) -> None:
        """Begin to plan."""
        self._thread.start()

    def see_surface(self, sighting: Sighting) -> None:
        """Hand over a newer surface; one that still waits is dropped."""
        with self._news:
            self._sighting = sighting
            self._news.notify()

    def see_arm(self, report: ArmReport) -> None:
        """Hand over what the arm says; a retraction is never overlooked."""
        with self._news:
            if self._arm is None or self._arm.state != State.RETRACTING:
                self._arm = report
            self._unheard = 0.0
            self._news.notify()

    def cancel(self) -> None:
        """Ask the job to end."""
        with self._news:
            self._canceled = True
            self._news.notify()

    def join(self, timeout: float = 5.0) -> None:
        """Wait for the thread's end, at most `timeout` [s]."""
        self._thread.join(timeout)

    def _run(self) -> None:
        code, message = Code.NONE, ""
        try:
            message = self._follow(self._plan())
        except BathbotError as error:
            code, message = code_of(error), str(error)
        except Exception as error:  # a goal whose thread died unseen would never end
            code, message = Code.TARGET_LOST, f"planning failed: {type(error).__name__}: {error}"
        self._done(Outcome(code, message, self._sent, self._length))

    def _follow(self, planner: PathPlanner) -> str:
        """Follow the path to its end; tell why that came early, empty when it did not."""
        seen, self._moved = time.monotonic(), time.monotonic()
        planner.map.watch_from(self._clock())
        while True:
            arm = self._wait()
            if self._at_end(planner, arm):
                if not planner.cut_short:
                    return ""
                return f"the path ended after {planner.fraction:.0%}, out of reach: {planner.cut_short}"
            self._demand_contact(arm)
            wanted = not planner.finished and self._with_arm(arm) < self._settings.ahead
            fresh = self._sighting is not None  # whoever moves is noticed at once
            if wanted or fresh or time.monotonic() - seen > self._settings.watch_period:
                seen = time.monotonic()
                self._look(planner)
            if wanted:
                start = time.perf_counter()
                segment = planner.next_segment()
                self._send(segment, time.perf_counter() - start, planner.fraction)
                self._sent += 1

    def _wait(self) -> ArmReport | None:
        with self._news:
            begun = time.monotonic()
            self._news.wait(_TICK)
            self._unheard += min(time.monotonic() - begun, 2.0 * _TICK)  # more: this process was held up
            if self._canceled:
                raise ScrubCanceledError(f"canceled after {self._sent} segments")
            return self._arm

    def _look(self, planner: PathPlanner) -> None:
        """Take in the newest surface, if there is one, and insist on seeing skin now and then."""
        with self._news:
            sighting, self._sighting = self._sighting, None
        if sighting is not None and sighting.stamp > planner.map.stamp:
            planner.map.see(sighting.decode(), sighting.stamp)
        planner.map.demand_in_sight(self._clock())

    def _with_arm(self, arm: ArmReport | None) -> int:
        """Segments sent and not yet left behind: robust against reports older than the last segment."""
        return self._sent - (0 if arm is None else arm.segment_on(self.path_id))

    def _at_end(self, planner: PathPlanner, arm: ArmReport | None) -> bool:
        if arm is None or arm.path_id != self.path_id or not self._sent:
            return False
        if arm.distance_along != self._length:
            self._length, self._moved = arm.distance_along, time.monotonic()
        return planner.finished and arm.path_done

    def _demand_contact(self, arm: ArmReport | None) -> None:
        """Raise when the arm does not scrub."""
        if self._unheard > self._settings.arm_state_max_age:
            raise ArmStoppedError(
                f"arm_state has been silent for {self._unheard:.1f} s; is rm65_driver running?"
            )
        if arm is None:
            return
        if arm.state == State.RETRACTING:
            raise ArmLeftError(f"the arm left the skin: {arm.reason or 'no reason given'}")
        if arm.state != State.CONTACT:
            raise ArmStoppedError(f"the arm is in {arm.state.name}: {arm.reason or 'no reason given'}")
        if is_refusal(arm.reason, self.path_id):
            raise SegmentRefusedError(f"the arm takes no more: {arm.reason}")
        if time.monotonic() - self._moved > self._settings.stall_timeout:
            raise ArmStoppedError(
                f"the arm did not move on along path {self.path_id} for {self._settings.stall_timeout} s, "
                f"it is on path {arm.path_id}, segment {arm.segment_index} "
                f"({arm.reason or 'no reason given'}); see the log of rm65_driver"
            )


def refusal(error: BathbotError) -> Outcome:
    """The outcome of a scrub that did not begin."""
    return Outcome(code_of(error), str(error), 0, 0.0)


def code_of(error: BathbotError) -> Code:
    """The error code of action/Scrub that stands for an error."""
    kinds: tuple[tuple[type[BathbotError], Code], ...] = (
        (OutOfReachError, Code.UNREACHABLE), (UnreachableError, Code.UNREACHABLE),
        (SegmentRefusedError, Code.UNREACHABLE),
        (TargetLostError, Code.TARGET_LOST), (SurfaceError, Code.NO_SURFACE),
        (ArmLeftError, Code.FORCE_LIMIT), (ArmStoppedError, Code.ARM_STOPPED),
        (NotReadyError, Code.NOT_READY), (ScrubCanceledError, Code.CANCELED),
    )  # fmt: skip
    return next((code for kind, code in kinds if isinstance(error, kind)), Code.NO_SURFACE)
