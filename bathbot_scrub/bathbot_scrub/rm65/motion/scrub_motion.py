"""The motion along a scrub path: takes its segments as they come, and says how far the head is."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.errors import ArmError, InvalidPoseError, NotReadyError
from bathbot_scrub.arm.force_limits import ForceLimits
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.arm.inverse_kinematics import check_poses
from bathbot_scrub.rm65.motion.arm_link import ArmLink
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from bathbot_scrub.rm65.motion.control_loop import NO_PATH, ControlLoop
from bathbot_scrub.rm65.motion.path_depth import Bristles, Felt, Skin, check_depth
from bathbot_scrub.rm65.motion.scrub_path import ScrubPath
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner, line_pace
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.segment.segment import Segment, refusal

Array = NDArray[np.float64]
_REMEMBERED = 16  # paths of which a segment was refused


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
        self._bristles = Bristles(limits.contact, limits.give / planner.arm.tool.give, planner.arm.tool.give)
        self._path: ScrubPath | None = None
        self._touch: Felt | None = None
        self._refusals: dict[int, str] = {}  # by path: why no more of it is taken

    @property
    def refusal(self) -> str:
        """Why no more is taken of the path followed, or sent last; the caller holds the loop's lock."""
        followed = self._path.path_id if self._path else None
        return self._refusals.get(followed) or next(reversed(self._refusals.values()), "")

    def touched(self, touch: Felt | None) -> None:
        """Know where an approach has felt skin; None: it goes elsewhere now, and no path goes on."""
        self._touch = touch
        with self._loop.lock:
            self._refusals.clear()
            self._loop.path_open, self._loop.awaits = False, NO_PATH

    def follow(self, segment: Segment) -> None:
        """Add a segment to the path; segment 0 starts a new one.

        The stricter limits hold of the region touched and of the path's; the latter does not change. Where a
        segment was refused, so are those behind it, for the same reason, until one comes that fits.

        Raises:
            NotReadyError: Not in contact, out of order, or the queue is full.
            UnreachableError, InvalidPoseError: The segment is refused as a whole.
        """
        if segment.index > self._next_of(segment.path_id) and segment.path_id in self._refusals:
            raise NotReadyError(self._refusals[segment.path_id])
        try:
            self._append(segment)
        except ArmError as error:
            self.refuse(segment.path_id, segment.index, str(error))
            raise

    def refuse(self, path_id: int, index: int, why: str) -> None:
        """Know that a segment was not taken: what comes behind it is refused for the same reason."""
        with self._loop.lock:
            if index <= self._next_of(path_id) or path_id not in self._refusals:
                self._refusals[path_id] = refusal(path_id, index, why)
            while len(self._refusals) > _REMEMBERED:
                del self._refusals[next(iter(self._refusals))]
            followed = self._path is not None and self._path.path_id == path_id
            if followed or not self._loop.path_open:
                self._loop.path_open, self._loop.awaits = False, self._refusals[path_id]

    def _next_of(self, path_id: int) -> int:
        """Index of the segment of a path that must come next."""
        return len(self._path.ends) if self._path and self._path.path_id == path_id else 0

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
        self._check_depth(segment)
        longer = path.extend(segment)
        with loop.lock:
            self._refusals.pop(path.path_id, None)
            loop.extend(longer)
            self._await(segment)

    def _begin(self, segment: Segment) -> None:
        region, loop, settings = self._limits.region(segment.region), self._loop, self._settings
        self._require_contact()
        start = loop.where()
        first = self._check_depth(segment)
        head = self._planner.arm.head(start)
        lead_in = self._planner.lead_in(head, first[0], settings.lift, settings.max_lead_in)
        path = ScrubPath(segment, self._planner, start, lead_in, settings.max_scrub_speed)
        pace = line_pace(settings.max_scrub_speed, settings.scrub_acceleration)
        with loop.lock:
            self._require_contact()
            loop.guard.begin_path(region.stricter(loop.guard.region))
            loop.begin(path.path, pace, MotionKind.SCRUB)
            self._path = path
            self._refusals.clear()
            self._await(segment)

    def _await(self, segment: Segment) -> None:
        """Know what must come behind a segment; the caller holds the loop's lock."""
        done = f"path {segment.path_id} is followed to its end, and nobody has retracted"
        more = f"segment {segment.index + 1} of path {segment.path_id} has not come"
        self._loop.path_open, self._loop.awaits = not segment.last, done if segment.last else more

    def _check_depth(self, segment: Segment) -> Array:
        """The segment's poses, shape (N, 4, 4), if none presses deeper than the skin known allows."""
        poses = check_poses(segment.T_base_heads)
        if poses.ndim != 3 or not len(poses):
            raise InvalidPoseError(f"segment {segment.index} holds no poses; send some")
        with self._loop.lock:
            head, wrench = self._planner.arm.head(self._loop.where()), self._link.wrench
        now = Felt(head, wrench.force if wrench else np.nan)
        around = self._planner.surroundings
        cloud = np.empty((0, 3)) if around is None else around.points
        check_depth(poses, Skin(self._touch or now, now, cloud), self._bristles)
        return poses

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
