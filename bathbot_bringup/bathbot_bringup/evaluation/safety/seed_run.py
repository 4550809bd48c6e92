"""All trials of one seed, on one graph for as long as it lives, and the program that runs them.

The program writes one line of JSON a trial.
"""

import contextlib
import json
import math
import signal
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.arm.states import State
from bathbot_scrub.installed_arm import installed_arm

from bathbot_bringup.errors import BringupError
from bathbot_bringup.evaluation.safety.fault_table import FaultCase, choose_faults
from bathbot_bringup.evaluation.safety.measures import (
    ALARMED,
    STANDS,
    TURNS,
    Reaction,
    Report,
    head_velocity,
    react,
    retract_begins,
    retract_delay,
)
from bathbot_bringup.evaluation.safety.trial.trial_graph import TrialGraph, trial_graph
from bathbot_bringup.evaluation.safety.trial.trial_run import SpoiltTrialError, TrialRun
from bathbot_bringup.evaluation.safety.trial.trial_site import TrialSite, find_site
from bathbot_bringup.evaluation.safety.trial_plan import REGION, Duty, Phase
from bathbot_bringup.evaluation.safety.trial_result import Bounds, TrialResult, judge
from bathbot_bringup.graph.interruption import interrupt
from bathbot_bringup.sim.arm.trace import TraceData, load_trace
from bathbot_bringup.sim.scenario import load_scenario
from bathbot_bringup.sim.scene import BathroomScene, true_camera_pose

SCENARIO = "calm"  # sim_rm65's own
_ATTEMPTS = 4
_LATER = 0.15  # [s] that every attempt strikes after the one before: a stroke may have been at its turn
_LATELY = 1.0  # [s] within which a brush in contact has touched: it may pass over a hollow

Tell = Callable[[TrialResult | dict[str, Any]], None]


class SeedRun:
    """Runs trials of one seed and starts the graph again where one has broken it."""

    def __init__(self, seed: int, folder: Path) -> None:
        """Find the site; `folder` takes logs and traces."""
        self._seed, self._folder = seed, folder
        self._kinematics = installed_arm()
        surface = BathroomScene(seed).surface(load_scenario(SCENARIO))
        self._site: TrialSite = find_site(surface, true_camera_pose(), self._kinematics)
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
            for case in sorted(cases, key=lambda case: case.injection.breaks_graph):
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
        plan, graph = case.plan(self._seed), self._open()
        plan = plan._replace(delay=plan.delay + _LATER * (attempt - 1))
        run = TrialRun(graph, self._site, plan, self._folder)
        try:
            injected = case.injection.inject(run, plan)
            trace, reports = self._trace(run, case, attempt), list(run.operator.arm.reports)
        except SpoiltTrialError:
            self._leave(run, case)
            raise
        self._leave(run, case)
        fault = case.injection.onset(injected, trace)
        trace = until(trace, injected.until)
        demand_phase(trace, fault, plan.phase, case.injection.is_touch)
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
        alarms = (State.CONTACT, *ALARMED) if case.injection.is_touch else ALARMED
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
        if case.injection.breaks_graph or not _recovers(run):
            self._close()

    def _open(self) -> TrialGraph:
        if self._graph is None:
            self._graph = self._graphs.enter_context(
                trial_graph(self._seed, self._site, self._folder / f"logs-{time.monotonic_ns()}")
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


def demand_phase(trace: TraceData, fault: float, phase: Phase, touched: bool) -> None:
    """Insist that the fault met the arm in the phase that was meant.

    Args:
        trace: From before the fault.
        fault: When it struck [s].
        phase: What the arm was meant to be about.
        touched: Whether it was meant to touch in any phase.

    Raises:
        SpoiltTrialError: When it did not.
    """
    before = slice(*np.searchsorted(trace.stamp, (fault - 0.05, fault)))
    if not len(trace.stamp[before]):
        raise SpoiltTrialError("the trace begins after the fault")
    speed = float(np.linalg.norm(head_velocity(trace)[before], axis=1).mean())
    turns = float(np.abs(trace.joint_speeds[before]).max(axis=1).mean())  # a way may turn about the head
    stands = speed < STANDS and turns < TURNS
    lately = slice(*np.searchsorted(trace.stamp, (fault - _LATELY, fault)))
    touches = bool((np.linalg.norm(trace.force[lately], axis=1) > 0.0).any())
    touching = phase in (Phase.REST, Phase.SCRUB) or touched
    if touches is not touching or stands is not (phase is Phase.REST):
        raise SpoiltTrialError(
            f"the fault did not meet the arm in phase {phase.value}: {1e3 * speed:.0f} mm/s, "
            f"{'in' if touches else 'no'} contact"
        )


def work(seed: int, names: list[str], folder: Path) -> None:
    """Run the trials of a seed.

    Args:
        seed: Which.
        names: Of the faults.
        folder: For traces, logs and `results.jsonl`.
    """
    folder.mkdir(parents=True, exist_ok=True)
    cases = choose_faults(names)
    with (folder / "results.jsonl").open("w", encoding="utf-8") as file:

        def tell(result: TrialResult | dict[str, Any]) -> None:
            entry = result._asdict() if isinstance(result, TrialResult) else result
            file.write(json.dumps(entry) + "\n")  # Infinity and NaN are read back by our own json
            file.flush()

        try:
            SeedRun(seed, folder).run(cases, tell)
        except BringupError as error:
            print(error, file=sys.stderr)
            raise SystemExit(1) from error


def main() -> None:
    """Run with: seed, names of faults with commas between, folder."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, interrupt)
    try:
        work(int(sys.argv[1]), sys.argv[2].split(","), Path(sys.argv[3]))
    except KeyboardInterrupt:
        raise SystemExit(130) from None


if __name__ == "__main__":
    main()
