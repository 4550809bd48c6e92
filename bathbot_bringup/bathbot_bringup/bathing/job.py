"""The whole job of bathing one region on a graph that runs already, simulated or real."""

from contextlib import suppress

from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

from bathbot_bringup.bathing import steps
from bathbot_bringup.bathing.client_node import Bather
from bathbot_bringup.errors import BringupError, StepError
from bathbot_bringup.graph.stages import StageLog

_SPEED = ScrubPlannerSettings().speed  # [m/s] turns a time into a length


class BathingJob:
    """Does the steps one after the other and shows them.

    Attributes:
        sighting: The contact target that was approached, once there is one.
    """

    def __init__(self, bather: Bather, log: StageLog, duration: float) -> None:
        """Prepare the job.

        Args:
            bather: Asks the graph.
            log: Shows the steps.
            duration: Longest time of scrubbing [s].
        """
        self._bather, self._log, self._duration = bather, log, duration
        self.sighting: steps.Sighting | None = None
        bather.tell = log.note

    def run(self) -> None:
        """Do it. A step that fails makes the arm leave the skin; Ctrl-C or a dead node makes it stop.

        Raises:
            StepError: Names the step that failed.
        """
        try:
            self._find()
            self._scrub()
            self._leave()
        except StepError:
            with suppress(BringupError):  # what failed first is what counts
                self._bather.withdraw()
            raise
        except BaseException:
            with suppress(BringupError):  # a dead driver cannot answer; its controller has stopped by itself
                self._bather.stop_arm()
            raise

    def _find(self) -> None:
        with self._log.stage("connect", steps.CONNECT.about):
            self._bather.connect()
            self._bather.home()
        with self._log.stage("look", steps.LOOK.about):
            self._bather.select()
            self.sighting = self._bather.look()
        self._log.note(str(self._bather.pace))

    def _scrub(self) -> None:
        with self._log.stage("approach", steps.APPROACH.about):
            contact = self._bather.approach(self.sighting, self._log.progress)
        self._log.note(f"skin felt with {contact.force:.1f} N")
        with self._log.stage("scrub", steps.SCRUB.about):
            scrubbed = self._bather.scrub(self._duration * _SPEED, self._log.progress)
        said = f"{scrubbed.segments} segments, {scrubbed.length:.2f} m of path"
        self._log.note(f"{said}; {scrubbed.error_msg}" if scrubbed.error_msg else said)

    def _leave(self) -> None:
        with self._log.stage("retract", steps.RETRACT.about):
            self._bather.retract()
        with self._log.stage("home", steps.HOME.about):
            self._bather.home()
