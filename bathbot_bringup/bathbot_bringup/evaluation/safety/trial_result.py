"""The numbers of one trial, and whether the arm did what it owes."""

from typing import NamedTuple

from bathbot_bringup.evaluation.safety.fault_table import FaultCase
from bathbot_bringup.evaluation.safety.measures import Reaction
from bathbot_bringup.evaluation.safety.trial_plan import TrialPlan


class Bounds(NamedTuple):
    """What the force may reach [N]."""

    retract: float  # threshold above which the arm leaves
    hard: float  # hard limit of the region


class TrialResult(NamedTuple):
    """One trial as it stands in the JSON file; infinite what never happened."""

    fault: str
    seed: int
    phase: str
    value: float
    stop_ms: float
    deadline_ms: float  # infinite where only the force counts
    detect_ms: float
    retract_ms: float  # NaN where the force never passed the threshold
    travel_mm: float
    peak_n: float
    force_bound_n: float
    moved_again: bool
    missed: bool
    attempts: int  # more than one where the arm had stopped before the fault
    said: str  # by the driver, after the fault


def judge(
    case: FaultCase,
    seed: int,
    plan: TrialPlan,
    reaction: Reaction,
    retract: float,
    bounds: Bounds,
    said: str,
    attempts: int,
) -> TrialResult:
    """Turn a reaction into a result; missed is what did not stop in time, or not for good."""
    return TrialResult(
        case.name, seed, plan.phase.value, plan.value,
        stop_ms=1e3 * reaction.stop,
        deadline_ms=1e3 * case.injection.deadline(plan.value),
        detect_ms=1e3 * reaction.detect,
        retract_ms=1e3 * retract,
        travel_mm=1e3 * reaction.travel,
        peak_n=reaction.peak,
        force_bound_n=bounds.retract if case.gentle else bounds.hard,
        moved_again=reaction.moved_again,
        missed=reaction.stop > case.injection.deadline(plan.value),
        attempts=attempts,
        said=said,
    )  # fmt: skip
