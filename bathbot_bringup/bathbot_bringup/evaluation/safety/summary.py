"""Many trials as one row per fault, and the times of retracts over all."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bathbot_bringup.evaluation.safety.fault_table import FAULTS
from bathbot_bringup.evaluation.safety.trial_plan import Duty
from bathbot_bringup.evaluation.safety.trial_result import TrialResult

RETRACT_P99, RETRACT_MAX = 10.0, 20.0  # [ms] one control period, two


def percentile(values: Sequence[float], share: float) -> float:
    """Smallest value that `share` (0..1) of all values do not exceed; NaN of none.

    Infinite values count as the largest, so that what never happened is not left out.
    """
    if not len(values):
        return math.nan
    return float(np.sort(np.asarray(values, dtype=float))[max(math.ceil(share * len(values)), 1) - 1])


def summarise(trials: Sequence[TrialResult], failures: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """All numbers of an evaluation.

    Args:
        trials: Whatever was measured.
        failures: Trials that could not be done: fault, seed and reason.
    """
    by_name = {case.name: [trial for trial in trials if trial.fault == case.name] for case in FAULTS}
    leaving = {case.name for case in FAULTS if case.duty is Duty.LEAVE}
    retracts = [
        trial.retract_ms for trial in trials if trial.fault in leaving and not math.isnan(trial.retract_ms)
    ]
    return {
        "simulated": True,
        "trials": len(trials),
        "failed": [dict(failure) for failure in failures],
        "retracts": len(retracts),
        "retract_ms_p50": percentile(retracts, 0.5),
        "retract_ms_p99": percentile(retracts, 0.99),
        "retract_ms_max": percentile(retracts, 1.0),
        "faults": [_row(name, found) for name, found in by_name.items() if found],
    }


def _row(name: str, trials: Sequence[TrialResult]) -> dict[str, Any]:
    stops = [trial.stop_ms for trial in trials]
    signs = [trial.detect_ms for trial in trials]
    return {
        "name": name,
        "trials": len(trials),
        "repeated": sum(trial.attempts - 1 for trial in trials),
        "missed": sum(trial.missed for trial in trials),
        "moved_again": sum(trial.moved_again for trial in trials),
        "undetected": sum(math.isinf(sign) for sign in signs),
        "deadline_ms": max(trial.deadline_ms for trial in trials),
        "stop_ms_p50": percentile(stops, 0.5),
        "stop_ms_p95": percentile(stops, 0.95),
        "stop_ms_max": percentile(stops, 1.0),
        "detect_ms_p50": percentile(signs, 0.5),
        "detect_ms_p95": percentile(signs, 0.95),
        "detect_ms_max": percentile(signs, 1.0),
        "overshoot_n_max": max(trial.peak_n for trial in trials),
        "force_bound_n": min(trial.force_bound_n for trial in trials),
        "too_hard": sum(trial.peak_n > trial.force_bound_n for trial in trials),
        "travel_mm_max": max(trial.travel_mm for trial in trials),
    }


def out_of_bounds(summary: Mapping[str, Any]) -> list[str]:
    """What an evaluation found to be wrong, one line each; empty when all is within its bounds."""
    found = [
        f"{failure['fault']}, seed {failure['seed']}: {failure['reason']}" for failure in summary["failed"]
    ]
    for row in summary["faults"]:
        if row["missed"]:
            found.append(f"{row['name']}: missed in {row['missed']} of {row['trials']} trials")
        if row["stop_ms_max"] > row["deadline_ms"]:
            found.append(
                f"{row['name']}: stop {row['stop_ms_max']:.0f} ms, more than {row['deadline_ms']:.0f} ms"
            )
        if row["too_hard"]:
            found.append(
                f"{row['name']}: {row['overshoot_n_max']:.1f} N, more than {row['force_bound_n']:g} N"
            )
    for key, most in (("retract_ms_p99", RETRACT_P99), ("retract_ms_max", RETRACT_MAX)):
        if summary[key] > most:
            found.append(f"{key}: {summary[key]:.1f} ms, more than {most:g} ms")
    return found
