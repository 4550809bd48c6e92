"""At most one scrub at a time: what is seen goes to it, and into what the next is planned from."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.force_limits import ForceLimits
from bathbot_scrub.errors import NotReadyError
from bathbot_scrub.job.scrub_inputs import ScrubInputs
from bathbot_scrub.job.scrub_job import ArmReport, Outcome, ScrubJob
from bathbot_scrub.path.planner import PathPlanner, Task
from bathbot_scrub.path.reach import Reach
from bathbot_scrub.path.surface_map import Sighting
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from bathbot_scrub.segment.segment import Segment


class Listeners(NamedTuple):
    """Who is told of one scrub; all but the first are called in its thread."""

    begun: Callable[[Task], None]
    chosen: Callable[[Task, PathPlanner], None]  # the path
    sent: Callable[[Segment, float, float], None]  # a segment, time to plan it [s], share sent so far
    broke_off: Callable[[], None]  # the arm must not use up what it was sent
    ended: Callable[[Outcome], None]  # and another may begin


class ScrubSession:
    """Hands what is seen to inputs and job, and lets one job begin when there is none."""

    def __init__(
        self,
        arm: Arm,
        limits: ForceLimits,
        settings: ScrubPlannerSettings,
        clock: Callable[[], float],
    ) -> None:
        """Begin without anything seen.

        Args:
            arm: That follows.
            limits: How far the head may be pressed in.
            settings: Of the planner.
            clock: Time [s] on the scale of the surfaces' stamps.
        """
        self._arm, self._limits, self._settings, self._clock = arm, limits, settings, clock
        self.inputs = ScrubInputs(settings)
        self._job: ScrubJob | None = None

    def see_arm(self, report: ArmReport) -> None:
        """Take in what the arm says."""
        self.inputs.before.see_arm(report)
        job = self._job  # it may end meanwhile, in its thread
        if job is not None:
            job.see_arm(report)

    def see_surface(self, sighting: Sighting) -> None:
        """Take in a surface."""
        self.inputs.before.see_surface(sighting)
        job = self._job
        if job is not None:
            job.see_surface(sighting)

    def begin(self, region: str, max_length: float, listeners: Listeners) -> None:
        """Scrub a region, at most `max_length` [m] of path; 0: all of the patch.

        Raises:
            NotReadyError, SurfaceError: As of `ScrubInputs.task`, or another scrub is on its way.
        """
        if self._job is not None:
            raise NotReadyError("another path is being scrubbed; wait for its end or cancel it")
        task = self.inputs.task(region, max_length, self._clock())
        self._job = job = ScrubJob(
            task.path_id,
            lambda: self._plan(task, listeners),
            listeners.sent,
            partial(self._end, listeners),
            self._clock,
            self._settings,
        )
        listeners.begun(task)
        job.see_arm(self.inputs.before.arm)
        job.start()

    def cancel(self) -> None:
        """Ask the scrub on its way to end, if there is one."""
        job = self._job
        if job is not None:
            job.cancel()

    def close(self) -> None:
        """End the scrub on its way and wait for that."""
        job = self._job
        if job is not None:
            job.cancel()
            job.join()

    def _plan(self, task: Task, listeners: Listeners) -> PathPlanner:
        """Choose the path, pressed in as is comfortable there."""
        pressed = self._limits.comfortable(task.region, self._settings.compression)
        reach = Reach(self._arm, task.joints, self.inputs.body(self._clock()))
        planner = PathPlanner(task, replace(self._settings, compression=pressed), reach)
        listeners.chosen(task, planner)
        return planner

    def _end(self, listeners: Listeners, outcome: Outcome) -> None:
        if outcome.broke_off:
            listeners.broke_off()
        self._job = None
        listeners.ended(outcome)
