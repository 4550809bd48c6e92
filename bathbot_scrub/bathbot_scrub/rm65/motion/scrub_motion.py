"""The motion along a scrub path: takes its segments as they come, and says how far the head is."""

from typing import NamedTuple

from bathbot_scrub.arm.errors import ArmError, NotReadyError
from bathbot_scrub.arm.force_limits import ForceLimits
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.arm.inverse_kinematics import check_poses
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from bathbot_scrub.rm65.motion.control_loop import ControlLoop
from bathbot_scrub.rm65.motion.scrub_path import ScrubPath
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner, line_pace
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.segment.segment import Segment


class Progress(NamedTuple):
    """How far the head is on the newest path."""

    path_id: int
    segment_index: int
    segments_queued: int
    distance_along: float  # [m]
    at_end: bool  # at rest at the end of what came so far
    done: bool  # and nothing more will come


class ScrubMotion:
    """Hands segments to the control loop. Thread-safe."""

    def __init__(
        self, loop: ControlLoop, planner: MotionPlanner, limits: ForceLimits, settings: DriverSettings
    ) -> None:
        """Work with these parts of a driver."""
        self._loop, self._planner, self._limits, self._settings = loop, planner, limits, settings
        self._path: ScrubPath | None = None
        self.refusal = ""  # why the newest segment was not taken

    def follow(self, segment: Segment) -> None:
        """Add a segment to the path; segment 0 starts a new one.

        Raises:
            NotReadyError: Not in contact, out of order, or the queue is full.
            UnreachableError, InvalidPoseError: The segment is refused as a whole.
        """
        try:
            self._append(segment)
            self.refusal = ""
        except ArmError as error:
            self.refusal = f"segment {segment.index} was refused: {error}"
            raise

    def progress(self) -> Progress:
        """Where the head is; the caller holds the loop's lock."""
        path, runner = self._path, self._loop.motion.runner
        if path is None or runner is None or self._loop.motion.kind is not MotionKind.SCRUB:
            return Progress(path.path_id if path else 0, 0, 0, 0.0, False, False)
        return Progress(
            path.path_id,
            path.segment_at(runner.length),
            path.queued_at(runner.length),
            path.travelled_at(runner.length),
            runner.at_end,
            path.finished and runner.at_end,
        )

    def _append(self, segment: Segment) -> None:
        path, loop = self._path, self._loop
        if path is None or path.path_id != segment.path_id or segment.index == 0:
            self._begin(segment)
            return
        with loop.lock:
            if path.queued_at(self._length(path)) >= self._settings.queue_length:
                raise NotReadyError(f"{self._settings.queue_length} segments wait already; send fewer ahead")
        longer = path.extend(segment)
        with loop.lock:
            loop.extend(longer)
            loop.path_open = not segment.last

    def _begin(self, segment: Segment) -> None:
        region, loop, settings = self._limits.region(segment.region), self._loop, self._settings
        self._require_contact()
        start = loop.where()
        first = check_poses(segment.T_base_heads)
        if first.ndim != 3 or not len(first):
            raise NotReadyError(f"path {segment.path_id} begins without poses; send some")
        head = self._planner.arm.head(start)
        lead_in = self._planner.lead_in(head, first[0], settings.lift, settings.max_lead_in)
        path = ScrubPath(segment, self._planner, start, lead_in, settings.max_scrub_speed)
        pace = line_pace(settings.max_scrub_speed, settings.scrub_acceleration)
        with loop.lock:
            self._require_contact()
            loop.guard.begin_path(region)
            loop.begin(path.path, pace, MotionKind.SCRUB)
            self._path, loop.path_open = path, not segment.last

    def _require_contact(self) -> None:
        guard = self._loop.guard
        if guard.state is not State.CONTACT:
            raise NotReadyError(
                f"a path begins in contact, but the arm is in {guard.state.name} ({guard.reason or 'idle'}); "
                "approach first"
            )
        if self._loop.moving:
            raise NotReadyError("the arm still follows another path; wait until it stands, or stop it")

    def _length(self, path: ScrubPath) -> float:
        runner = self._loop.motion.runner
        if runner is None or self._loop.motion.kind is not MotionKind.SCRUB:
            guard = self._loop.guard
            raise NotReadyError(
                f"path {path.path_id} was given up: {guard.reason or guard.state.name}; begin a new one"
            )
        return runner.length
