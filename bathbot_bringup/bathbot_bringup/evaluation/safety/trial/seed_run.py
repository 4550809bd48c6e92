"""All trials of one seed, on one graph for as long as it lives."""

import contextlib
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from bathbot_scrub.rm65.arm.kinematics import Kinematics
from bathbot_scrub.rm65.force.force_limits import shipped_force_limits
from bathbot_scrub.rm65.guard.states import State

from bathbot_bringup.errors import BringupError
from bathbot_bringup.evaluation.safety.fault_table import REGION, Duty, FaultCase, Nearer, Phase, Strike
from bathbot_bringup.evaluation.safety.measures import (
    ALARMED,
    STANDS,
    Reaction,
    Report,
    head_velocity,
    react,
    retract_begins,
    retract_delay,
)
from bathbot_bringup.evaluation.safety.trial.fault_injection import onset, strike_at
from bathbot_bringup.evaluation.safety.trial.site import Place, find_place
from bathbot_bringup.evaluation.safety.trial.trial_graph import TrialGraph, trial_graph
from bathbot_bringup.evaluation.safety.trial.trial_run import SpoiltTrialError, TrialRun
from bathbot_bringup.evaluation.safety.trial_plan import plan_trial
from bathbot_bringup.evaluation.safety.trial_result import Bounds, TrialResult, judge
from bathbot_bringup.sim.arm.trace import TraceData, load_trace
from bathbot_bringup.sim.scenario import load_scenario
from bathbot_bringup.sim.scene import BathroomScene

SCENARIO = "calm"  # sim_rm65's own
_ATTEMPTS = 4
_LATER = 0.15  # [s] that every attempt strikes after the one before: a stroke may have been at its turn
_LATELY = 1.0  # [s] within which a brush in contact has touched: it may pass over a hollow

Tell = Callable[[TrialResult | dict[str, Any]], None]


class SeedRun:
    """Runs trials of one seed and starts the graph again where one has broken it."""

    def __init__(self, seed: int, folder: Path) -> None:
        """Find the place; `folder` takes logs and traces."""
        self._seed, self._folder = seed, folder
        self._kinematics = Kinematics()
        surface = BathroomScene(seed).surface(load_scenario(SCENARIO))
        self._place: Place = find_place(surface, self._kinematics)
        region = shipped_force_limits().region(REGION)
        self._bounds = Bounds(region.retract, region.hard_stop)
        self._graphs = contextlib.ExitStack()
        self._graph: TrialGraph | None = None

    def run(self, cases: Sequence[FaultCase], tell: Tell) -> None:
        """Run one trial of each fault; what breaks the graph comes last.

        Args:
            cases: Which faults.
            tell: Takes each result, or what could not be done: fault, seed and reason.
        """
        with self._graphs:
            for case in sorted(cases, key=lambda case: case.breaks_graph):
                tell(self._try(case))

    def _try(self, case: FaultCase) -> TrialResult | dict[str, Any]:
        reason = ""
        for attempt in range(1, _ATTEMPTS + 1):
            try:
                return self._trial(case, attempt)
            except SpoiltTrialError as error:
                reason = str(error)
            except BringupError as error:
                reason = str(error)
                self._close()
        return {"fault": case.name, "seed": self._seed, "reason": reason}

    def _trial(self, case: FaultCase, attempt: int) -> TrialResult:
        plan, graph = plan_trial(case, self._seed), self._open()
        plan = plan._replace(delay=plan.delay + _LATER * (attempt - 1))
        run = TrialRun(graph, self._place, plan, self._folder)
        try:
            struck = strike_at(case.strike, run, plan)
            trace, reports = self._trace(run, case, attempt), list(run.operator.reports)
        except SpoiltTrialError:
            self._leave(run, case)
            raise
        self._leave(run, case)
        fault = onset(struck, trace, case.strike)
        trace = until(trace, struck.until)
        demand_phase(trace, fault, plan.phase, case.strike)
        said = (report.reason for report in reports if report.stamp > fault and report.reason)
        return judge(
            case, self._seed, plan, self._measure(case, plan.phase, trace, fault, reports),
            retract_delay(trace, fault, self._bounds.retract, self._kinematics)
            if case.duty is Duty.LEAVE else math.nan,
            self._bounds, "; ".join(dict.fromkeys(said)), attempt,
        )  # fmt: skip

    def _measure(
        self, case: FaultCase, phase: Phase, trace: TraceData, fault: float, reports: Sequence[Report]
    ) -> Reaction:
        """The reaction; contact tells of a body that is nearer, the first frame of a retract of a push."""
        alarms = (State.CONTACT, *ALARMED) if isinstance(case.strike, Nearer) else ALARMED
        reaction = react(trace, fault, phase, case.duty, reports, alarms)
        if case.duty is not Duty.LEAVE:
            return reaction
        begun = retract_begins(trace, fault, self._kinematics) - fault
        return reaction._replace(detect=min(reaction.detect, begun))

    def _trace(self, run: TrialRun, case: FaultCase, attempt: int) -> TraceData:
        path = self._folder / f"{case.name}-{self._seed}-{attempt}-{time.monotonic_ns()}.npz"
        run.record(path)
        return load_trace(path)

    def _leave(self, run: TrialRun, case: FaultCase) -> None:
        """Bring the arm back, or have the graph started again."""
        if case.breaks_graph or not _recovers(run):
            self._close()

    def _open(self) -> TrialGraph:
        if self._graph is None:
            self._graph = self._graphs.enter_context(
                trial_graph(self._seed, self._place, self._folder / f"logs-{time.monotonic_ns()}")
            )
        return self._graph

    def _close(self) -> None:
        self._graph = None
        self._graphs.close()


def _recovers(run: TrialRun) -> bool:
    try:
        run.recover()
    except BringupError:
        return False
    return True


def until(trace: TraceData, end: float) -> TraceData:
    """The steps and frames of a trace up to a time [s]."""
    steps, frames = int(np.searchsorted(trace.stamp, end)), int(np.searchsorted(trace.frame_stamp, end))
    cut = {name: getattr(trace, name)[:steps] for name in TraceData._fields[:9]}
    return trace._replace(
        **cut, frame_stamp=trace.frame_stamp[:frames], frame_joints=trace.frame_joints[:frames]
    )


def demand_phase(trace: TraceData, fault: float, phase: Phase, strike: Strike) -> None:
    """Insist that the fault met the arm in the phase that was meant.

    Raises:
        SpoiltTrialError: When it did not.
    """
    before = slice(*np.searchsorted(trace.stamp, (fault - 0.05, fault)))
    if not len(trace.stamp[before]):
        raise SpoiltTrialError("the trace begins after the fault")
    speed = float(np.linalg.norm(head_velocity(trace)[before], axis=1).mean())
    lately = slice(*np.searchsorted(trace.stamp, (fault - _LATELY, fault)))
    touches = bool((np.linalg.norm(trace.force[lately], axis=1) > 0.0).any())
    touching = phase in (Phase.REST, Phase.SCRUB) or isinstance(strike, Nearer)
    if touches is not touching or (speed < STANDS) is not (phase is Phase.REST):
        raise SpoiltTrialError(
            f"the fault did not meet the arm in phase {phase.value}: {1e3 * speed:.0f} mm/s, "
            f"{'in' if touches else 'no'} contact"
        )
