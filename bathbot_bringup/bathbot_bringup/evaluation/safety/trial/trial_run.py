"""One trial on a running graph: bring the arm into a phase, let time pass, and bring it back."""

import itertools
import time
from pathlib import Path
from typing import Any

import numpy as np
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.motion.commanded_motion import ARRIVALS, MotionKind
from numpy.typing import NDArray

from bathbot_bringup.errors import BringupError
from bathbot_bringup.evaluation.safety.trial.stroke_player import SPACING, LastPose, StrokePlayer
from bathbot_bringup.evaluation.safety.trial.trial_graph import TrialGraph
from bathbot_bringup.evaluation.safety.trial.trial_site import TrialSite
from bathbot_bringup.evaluation.safety.trial_plan import REGION, Phase, TrialPlan

Array = NDArray[np.float64]
STANDOFF = {
    Phase.TRANSIT: 0.04,
    Phase.SEEK: 0.04,
    Phase.REST: 0.025,
    Phase.SCRUB: 0.025,
}  # [m] of the approach
DEPTH = 0.0035  # [m] into the skin
_IN_TIME = 20.0  # [s] for any step
_OFF_AXIS, _BEGUN = 0.002, 0.004  # [m] beside the approach's line; along it, or from the start
_AWAY = 0.04  # [m] of the head from its target, off the skin
_AT_END = 0.001  # [m] of the last pose
_NEWS = 0.15  # [s] in which reports may be older than a request
_STAYS = 0.6  # [s]; a stroke that turns about there is gone in less
_STILL = 0.15  # [s] in contact after which the search has come to rest
_RECOVERY = 15.0  # [s]
_paths = itertools.count(1)


class SpoiltTrialError(BringupError):
    """A trial in which the arm was not where the fault should meet it."""


class TrialRun:
    """The arm's side of one trial."""

    def __init__(self, graph: TrialGraph, site: TrialSite, plan: TrialPlan, folder: Path) -> None:
        """Prepare a trial at a site; `folder` takes its files."""
        self.graph, self._plan, self.folder = graph, plan, folder
        self.operator, self._spin = graph.operator, graph.client.spin_until
        x, y = plan.shift
        self.target = site.target((x * site.room, y * site.room), plan.heading)
        self.stroke = site.stroke(self.target, 0.5 * site.room, SPACING, DEPTH)
        self.player = StrokePlayer(next(_paths), REGION, self.stroke, plan.speed)
        self.surface = site.surface
        self.feed = self._feed  # plays the planner; replaced where another process does
        self.engage = lambda: None  # asks that process to begin
        self._result: Any = None

    def bring_about(self, deeper: float = 0.0) -> None:
        """Bring the arm into the phase in which the fault strikes, and wait for the moment.

        Args:
            deeper: By which the target lies behind the skin [m].

        Raises:
            SpoiltTrialError: When it does not come there.
        """
        phase = self._plan.phase
        resting = (State.FREE, State.HOLD)
        self._until(lambda: self.operator.arm.state in resting, "the arm did not come to rest")
        if phase is Phase.TRANSIT:
            self._go_home()
        start = self.operator.arm.head[0]
        self.operator.forget()
        target = self.target.copy()
        target[:3, 3] += deeper * target[:3, 2]
        self._result = self.operator.approach(target, STANDOFF[phase])
        if phase is Phase.TRANSIT:
            self._until(lambda: np.linalg.norm(self.operator.arm.head[0] - start) > _BEGUN, "no way began")
        elif phase is Phase.SEEK:
            self._until(lambda: self._seeks(target), "the search for the skin did not begin")
        else:
            self._touch()
        self.play(self._plan.delay * (0.5 if phase is Phase.TRANSIT else 1.0))

    def _go_home(self) -> None:
        """Wait where the arm is ready: the way from there is long enough to be met on."""
        if refusal := self.operator.ask("home"):
            raise SpoiltTrialError(refusal)
        asked = time.monotonic()

        def there() -> bool:
            newest = self.operator.arm.reports[-1]
            return newest.stamp > asked + _NEWS and newest.reason == ARRIVALS[MotionKind.HOME]

        self._until(there, "the arm did not come home")

    def _seeks(self, target: Array) -> bool:
        offset = target[:3, 3] - self.operator.arm.head[0]
        along = float(offset @ target[:3, 2])
        beside = float(np.linalg.norm(offset - along * target[:3, 2]))
        return beside < _OFF_AXIS and 0.0 < along < STANDOFF[Phase.SEEK] - _BEGUN

    def _touch(self) -> None:
        """Come into contact and, where that is the phase, begin to scrub."""
        self._until(self._result.done, "the approach did not end")
        outcome = self._result.result().result
        if outcome.error_code:
            raise SpoiltTrialError(f"approach: {outcome.error_msg}")
        self._until(lambda: self.operator.arm.state == State.CONTACT, "no contact was told")
        self.wait(_STILL)
        if self._plan.phase is Phase.SCRUB:
            self.begin_to_scrub()

    def begin_to_scrub(self) -> None:
        """Play the planner, or have it played, until the arm follows the stroke."""
        self.engage()
        self._until(lambda: self.feed() or self._follows(), "the stroke did not begin")

    def _follows(self) -> bool:
        """Whether the arm has come to the second segment of the newest path."""
        progress, path = self.operator.arm.progress, self.operator.arm.last_pose
        if progress is None or path is None:
            return False
        return progress.path_id == path.path_id and progress.segment_index > 0

    def _feed(self) -> None:
        segment = self.player.due(self.operator.arm.progress)
        if segment is not None:
            self.operator.send(segment)

    def play(self, seconds: float) -> None:
        """Let time pass [s]; where the arm scrubs, the planner goes on as if nothing had happened."""
        scrubbing = self._plan.phase is Phase.SCRUB
        self._spin(lambda: scrubbing and self.feed(), seconds)

    def wait(self, seconds: float) -> None:
        """Let time pass without a planner [s]."""
        self.graph.client.wait(seconds)

    def wait_until_due(self) -> None:
        """Wait until a planner would send its next segment."""
        self._until(lambda: self.player.is_due(self.operator.arm.progress), "no segment was due")

    def wait_until_starved(self) -> None:
        """Wait until the head has come to the end of what it was given."""
        end = self.path_end().position

        def there() -> bool:
            return bool(np.linalg.norm(self.operator.arm.head[0] - end) < _AT_END)

        def stays() -> bool:  # a stroke passes by its end on the way
            return there() and not self._spin(lambda: not there(), _STAYS)

        self._until(stays, "it did not come to the end")

    def wait_for_planner(self) -> None:
        """Wait until another process may send segments."""
        self._until(lambda: self.operator.planners() > 1, "no planner came")

    def path_end(self) -> LastPose:
        """Where the path ends that the arm was given."""
        if self.operator.arm.last_pose is None:
            raise SpoiltTrialError("no segment was heard")
        return self.operator.arm.last_pose

    def record(self, path: Path) -> None:
        """Have the trace written."""
        self.operator.sim.write_trace(path)

    def recover(self) -> None:
        """Mend what was broken and bring the arm off the skin.

        Raises:
            SpoiltTrialError: When it does not come.
        """
        operator, deadline = self.operator, time.monotonic() + _RECOVERY
        operator.sim.order({"kind": "none"})
        self.graph.mend()
        refusal = ""
        while time.monotonic() < deadline:
            self.wait(0.1)
            state = operator.arm.state
            away = np.linalg.norm(operator.arm.head[0] - self.target[:3, 3]) > _AWAY
            if state == State.FREE:
                operator.ask("resume")  # a driver that was started again wants somebody's word; others refuse
                return
            if state == State.APPROACH:
                refusal = operator.ask("stop")
            elif state == State.FAULT or (state == State.HOLD and away):
                refusal = operator.ask("resume")
            if state == State.CONTACT or (state == State.HOLD and (refusal or not away)):
                refusal = operator.ask("retract")
        raise SpoiltTrialError(f"the arm did not recover: {refusal or operator.arm.reason}")

    def _until(self, condition: Any, complaint: str) -> None:
        if not self._spin(condition, _IN_TIME):
            said = self.operator.arm.reason
            raise SpoiltTrialError(f"{complaint} {said and f'({said})'}")
