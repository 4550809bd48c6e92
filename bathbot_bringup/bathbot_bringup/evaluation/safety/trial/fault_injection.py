"""How each fault is brought about on a running trial, and from when its reaction counts.

A row of the fault table names one of these injections. Each brings the arm into the phase, lets the fault
happen, watches, and tells afterwards, from the trace, when the fault began.
"""

import math
import sys
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

from bathbot_bringup.evaluation.safety.trial.stroke_player import LastPose, spoilt
from bathbot_bringup.evaluation.safety.trial.trial_run import SpoiltTrialError, TrialRun
from bathbot_bringup.evaluation.safety.trial.trial_site import seen_skin
from bathbot_bringup.evaluation.safety.trial_plan import DEADLINE, TrialPlan
from bathbot_bringup.sim.arm.trace import TraceData

if TYPE_CHECKING:
    from bathbot_bringup.evaluation.safety.trial.fake_localizer_node import FakeLocalizer

PLAYER = "stroke_player"
WATCH = 1.2  # [s] after a fault
LATE = 1.0  # [s] of a segment
_RUN_OUT = 4.5  # [s] in which the arm must have come to the end of what it was given
_COMES = 5.0  # [s] in which an arm that began comes to its stand-off
_LOOK = 1.5  # [s] before the arm comes
_MOVED = 0.03  # [m] away from the arm; scrub_planner allows 0.02
_AT_END, _STAYS = 0.002, 120  # [m] of the last pose; samples: who passes by on the way is gone in less


class Injected(NamedTuple):
    """What was done, by the clock of the trace."""

    stamp: float  # [s] when it was done; for faults of the emulator the trace tells better
    path_end: LastPose | None = None  # of a path that was not gone on with
    until: float = math.inf  # [s] to which the reaction counts: then the arm may go on


class Injection(ABC):
    """A way to make something fail.

    Attributes:
        breaks_graph: Whether a process is gone afterwards, so that the graph must be started again.
        is_touch: Whether the fault is a touch that comes early: contact is then its sign.
    """

    breaks_graph: ClassVar[bool] = False
    is_touch: ClassVar[bool] = False

    def strength(self, rng: np.random.Generator) -> float:
        """Draw how strong it is; NaN where that is not a matter of chance."""
        return math.nan

    def deadline(self, value: float) -> float:
        """Time from the fault, of a strength, to standing still or leaving [s] that the arm has."""
        return DEADLINE

    @abstractmethod
    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Bring the arm into the phase, let the fault happen, and watch.

        Raises:
            SpoiltTrialError: When the arm does not come into the phase.
        """

    def onset(self, injected: Injected, trace: TraceData) -> float:
        """When the fault began, by the trace [s].

        Raises:
            SpoiltTrialError: When it did not begin at all.
        """
        return injected.stamp


@dataclass(frozen=True, slots=True)
class Ordered(Injection):
    """A fault of the emulated controller, ordered on `sim_fault`; it begins when the emulator says so."""

    kind: str
    lowest: float | None = None  # of its value; None: the kind's own
    highest: float | None = None
    duration: float = 0.6  # [s] after which all is well again: the arm must not go on by itself

    def strength(self, rng: np.random.Generator) -> float:
        """Draw its value."""
        if self.lowest is None or self.highest is None:
            return math.nan
        if isinstance(self.lowest, int):
            return float(rng.integers(self.lowest, self.highest + 1))
        return float(rng.uniform(self.lowest, self.highest))

    def order(self, value: float) -> float:
        """Value of the fault that is ordered, where a strength was drawn; NaN: the kind's own."""
        return value

    def lasting(self, value: float) -> float:
        """For how long [s]."""
        return self.duration

    def watch(self, lasts: float) -> float:
        """Time [s] to look on, from the order of a fault that lasts so long [s]."""
        return max(lasts + 0.5, WATCH)

    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Order it."""
        run.bring_about()
        lasts = self.lasting(plan.value)
        fault: dict[str, float | str] = {"kind": self.kind, "after": plan.offset, "duration": lasts}
        if math.isfinite(value := self.order(plan.value)):
            fault["value"] = value
        stamp = time.monotonic()
        run.operator.sim.order(fault)
        run.play(self.watch(lasts))
        return Injected(stamp)

    def onset(self, injected: Injected, trace: TraceData) -> float:
        """As the emulator noted."""
        begun = trace.event_stamp[(trace.event_kind == self.kind) & (trace.event_phase == "begin")]
        if not len(begun):
            raise SpoiltTrialError(f"the emulator did not begin the fault {self.kind}")
        return float(begun[0])


@dataclass(frozen=True, slots=True)
class Coming(Ordered):
    """The body comes into the brush by a distance, at speeds that are drawn evenly by their logarithm."""

    far: float = 0.05  # [m]

    def strength(self, rng: np.random.Generator) -> float:
        """Draw the speed [m/s]."""
        return float(np.exp(rng.uniform(np.log(self.lowest), np.log(self.highest))))

    def deadline(self, value: float) -> float:
        """The usual, and the time in which the body uses up what the bristles give."""
        return DEADLINE + SCRUB_HEAD.give / value

    def lasting(self, value: float) -> float:
        """Time in which it comes so far [s]."""
        return self.far / value


@dataclass(frozen=True, slots=True)
class LeaningIn(Ordered):
    """The person leans into the way of the arm by a distance that is drawn [m]; only the force counts."""

    speed: float = 0.2  # [m/s]

    def deadline(self, value: float) -> float:
        """None: the arm may go on, and touch."""
        return math.inf

    def order(self, value: float) -> float:
        """The speed."""
        return self.speed

    def lasting(self, value: float) -> float:
        """Time in which the person leans so far [s]."""
        return value / self.speed

    def watch(self, lasts: float) -> float:
        """Until the arm has come to where the person is: it is slow near people."""
        return lasts + _COMES


@dataclass(frozen=True, slots=True)
class Jammed(Ordered):
    """The joint that moves fastest does not move any more."""

    kind: str = "following_error"

    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Jam the joint that is fastest when the moment has come."""
        run.bring_about()
        stamp, joint = time.monotonic(), run.operator.arm.fastest_joint()
        order = {"kind": self.kind, "after": plan.offset, "duration": self.duration, "value": joint}
        run.operator.sim.order(order)
        run.play(WATCH)
        return Injected(stamp)


@dataclass(frozen=True, slots=True)
class Nearer(Injection):
    """A body nearer than the target says; the fault is the touch that comes early."""

    distance: float  # [m]
    is_touch: ClassVar[bool] = True

    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Have the arm seek skin behind the skin."""
        stamp = time.monotonic()
        run.bring_about(self.distance)
        run.play(WATCH + 1.0)
        return Injected(stamp)

    def onset(self, injected: Injected, trace: TraceData) -> float:
        """When the true force is what counts as felt."""
        felt = np.linalg.norm(trace.force, axis=1) >= shipped_force_limits().contact
        return _first(trace, felt, "the brush did not touch")


@dataclass(frozen=True, slots=True)
class Frozen(Injection):
    """A process that does not run for a while."""

    node: str
    duration: float  # [s]

    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Stop the process, and let it go on."""
        run.bring_about()
        stamp = run.graph.freeze(self.node)
        run.play(self.duration)
        run.graph.thaw(self.node)
        run.play(WATCH)
        return Injected(stamp)


@dataclass(frozen=True, slots=True)
class Killed(Injection):
    """A process that dies at once."""

    node: str
    breaks_graph: ClassVar[bool] = True

    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Kill the process."""
        run.bring_about()
        stamp = run.graph.kill(self.node)
        run.play(WATCH)
        return Injected(stamp)


class SilentPlanner(Injection):
    """The planner sends no segment any more.

    The fault begins when the head comes to stay at the end of what it was given: up to there it has good
    data. So with every planner that fails.
    """

    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Send nothing good once a segment is due."""
        run.bring_about()
        run.wait_until_due()
        stamp = time.monotonic()
        self.send_instead(run)
        run.wait(_RUN_OUT)
        return Injected(stamp, path_end=run.path_end())

    def send_instead(self, run: TrialRun) -> None:
        """What is sent instead of good segments: nothing."""

    def onset(self, injected: Injected, trace: TraceData) -> float:
        """When the head comes to stay within 2 mm of the last pose it was given."""
        end = injected.path_end
        near = np.linalg.norm(trace.head - end.position, axis=1) < _AT_END
        after = trace.stamp > max(injected.stamp, end.stamp)
        from_here_on = np.convolve(near & after, np.ones(_STAYS), "full")[_STAYS - 1 :]
        return _first(trace, from_here_on > _STAYS - 0.5, "the path did not run out")


class BadPlanner(SilentPlanner):
    """The planner sends segments that are not finite."""

    def send_instead(self, run: TrialRun) -> None:
        """What is sent instead of good segments: poses that are no numbers."""
        for _ in range(5):
            run.operator.send(spoilt(run.player.take()))


class LatePlanner(SilentPlanner):
    """The planner sends its next segment a second too late."""

    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Keep a segment back until the path has run out, and longer."""
        run.bring_about()
        run.wait_until_due()
        stamp = time.monotonic()
        run.wait_until_starved()
        run.wait(LATE)
        path_end, until = run.path_end(), time.monotonic()
        run.play(WATCH)
        return Injected(stamp, path_end=path_end, until=until)


class KilledPlanner(SilentPlanner):
    """The planner's process dies at once."""

    breaks_graph: ClassVar[bool] = True

    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Have the stroke played by a process of its own, and kill that."""
        _play_elsewhere(run, plan)
        run.bring_about()
        stamp = run.graph.kill(PLAYER)
        run.wait(_RUN_OUT)
        return Injected(stamp, path_end=run.path_end())


class SkinMoved(Injection):
    """The skin that the real planner scrubs by is seen 30 mm farther away, from the first such picture on."""

    def inject(self, run: TrialRun, plan: TrialPlan) -> Injected:
        """Have the real planner scrub, and change what it sees."""
        run.graph.start_planner()
        with run.graph.localizer(seen_skin(run.surface, run.target), run.target) as localizer:
            run.feed, run.engage = lambda: None, run.operator.scrub
            run.wait(_LOOK)
            run.bring_about()
            stamp = self.change(localizer)
            run.wait(stamp - time.monotonic() + WATCH)
        return Injected(stamp)

    def change(self, localizer: "FakeLocalizer") -> float:
        """Change what is seen; gives the time from which the planner must know [s]."""
        return localizer.move(_MOVED)


class SkinLost(SkinMoved):
    """The skin is not seen any more; that begins when the last picture is as old as the planner allows."""

    def change(self, localizer: "FakeLocalizer") -> float:
        """See nothing any more; gives the time from which the planner must know [s]."""
        return localizer.lose() + ScrubPlannerSettings().lost_after


def _first(trace: TraceData, condition: np.ndarray, complaint: str) -> float:
    found = np.flatnonzero(condition)
    if not len(found):
        raise SpoiltTrialError(complaint)
    return float(trace.stamp[found[0]])


def _play_elsewhere(run: TrialRun, plan: TrialPlan) -> None:
    """Have the stroke played by a process of its own, which may be killed."""
    file = run.folder / "stroke.npz"
    np.savez(file, stroke=run.stroke, speed=plan.speed, path_id=run.player.path_id)
    module = "bathbot_bringup.evaluation.safety.trial.stroke_player_node"
    run.graph.start(PLAYER, [sys.executable, "-m", module, str(file)])
    run.wait_for_planner()
    run.feed = lambda: None
