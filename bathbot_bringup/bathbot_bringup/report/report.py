"""From a finished run to its summary and its page."""

import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bathbot_bringup.bag.reading import notes_of
from bathbot_bringup.bag.recording.recorder import LOST
from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.bathing.steps import Sighting
from bathbot_bringup.errors import BagError
from bathbot_bringup.files import plain, write_json
from bathbot_bringup.graph.installation import version
from bathbot_bringup.report.measures import RunMeasures, measure_run
from bathbot_bringup.report.run_data import Run, read_run
from bathbot_bringup.report.truth import Truth, seen_target

BAG = "run.mcap"


class Outcome(NamedTuple):
    """How a run ended.

    Attributes:
        failure: Why it was not done; empty when it was.
        epoch: ROS time at which the body's motion began [s].
        sighting: The contact target that was approached; None when none was found.
        times: Duration of each stage [s].
        duration: Of the whole run so far [s].
    """

    failure: str
    epoch: float
    sighting: Sighting | None
    times: dict[str, float]
    duration: float


def report_run(settings: DemoSettings, outcome: Outcome) -> dict[str, Any]:
    """Write `summary.json` and, when there is a bag, `report.html`; give the summary.

    A run that failed early has a summary too, with null for every number it cannot know.
    """
    begun = time.monotonic()
    summary = head_of_summary(settings, outcome)
    try:
        run = read_run(settings.out / BAG)
    except BagError as error:
        summary |= {"done": False, "failure": outcome.failure or str(error)}
    else:
        truth = Truth(settings, outcome.epoch)
        measures = measure_run(run, truth, settings.region)
        summary |= numbers(measures, outcome, truth)
        summary["messages_lost"] = _lost(settings.out / BAG)
        summary["duration_s"] = round(outcome.duration + time.monotonic() - begun, 2)
        _write_page(settings, outcome, summary, run, measures)
    write_json(settings.out / "summary.json", summary)
    return plain(summary)


def head_of_summary(settings: DemoSettings, outcome: Outcome) -> dict[str, Any]:
    """What is known without the bag."""
    return {
        "done": not outcome.failure,
        "failure": outcome.failure,
        "simulated": True,
        "seed": settings.seed,
        "region": settings.region,
        "scenario": settings.scenario,
        "preset": settings.preset,
        "camera_rate_hz": settings.rate,
        "version": version(),
        "epoch": outcome.epoch,
        "target_time_s": outcome.sighting.time - outcome.epoch if outcome.sighting else None,
        "duration_s": round(outcome.duration, 2),
        "stages_s": dict(outcome.times),
        **dict.fromkeys(_NUMBERS),
    }


_NUMBERS = (
    "localization_error_mm", "localization_error_axes_mm", "localization_mean_mm", "localization_max_mm",
    "localization_count", "path_y_error_max_mm", "path_y_error_mean_mm", "path_depth_error_max_mm",
    "path_length_m", "contact_fraction", "coverage", "patch_area_cm2", "comfort_fraction", "force_mean_n",
    "force_peak_n", "force_threshold_n", "compression_min_mm", "compression_max_mm",
    "command_period_p99_dev_ms", "messages_lost",
)  # fmt: skip


def numbers(measures: RunMeasures, outcome: Outcome, truth: Truth) -> dict[str, Any]:
    """Put the measures into the units of the summary."""
    error, contact = measures.error, measures.contact
    used = _error_of_used(outcome.sighting, truth)
    before = measures.target_times <= (outcome.sighting.time if outcome.sighting else -np.inf)
    free = 1000.0 * np.linalg.norm(measures.target_errors[before], axis=1)
    return {
        "localization_error_mm": 1000.0 * np.linalg.norm(used),
        "localization_error_axes_mm": list(1000.0 * used),
        "localization_mean_mm": _of(np.nanmean, free),
        "localization_max_mm": _of(np.nanmax, free),
        "localization_count": len(free),
        "path_y_error_max_mm": 1000.0 * _of(np.nanmax, np.abs(error.across)),
        "path_y_error_mean_mm": 1000.0 * _of(np.nanmean, np.abs(error.across)),
        "path_depth_error_max_mm": 1000.0 * _of(np.nanmax, np.abs(error.depth)),
        "path_length_m": error.distance[-1] if len(error.distance) else np.nan,
        "contact_fraction": contact.fraction,
        "coverage": measures.coverage.fraction,
        "patch_area_cm2": len(measures.coverage.samples) * 0.09,
        "comfort_fraction": contact.comfort_fraction,
        "force_mean_n": contact.force_mean,
        "force_peak_n": contact.force_peak,
        "force_threshold_n": measures.force_threshold,
        "compression_min_mm": 1000.0 * contact.compression_min,
        "compression_max_mm": 1000.0 * contact.compression_max,
        "command_period_p99_dev_ms": 1000.0 * measures.period_deviation,
    }


def _lost(bag: Path) -> int | None:
    """Messages that the recorder says the bag lacks; None when it did not live to say so."""
    said = notes_of(bag).get(LOST)
    return None if said is None else int(said)


def _error_of_used(sighting: Sighting | None, truth: Truth) -> np.ndarray:
    """Found minus true position of the target that was approached [m]; NaN when there was none."""
    if sighting is None:
        return np.full(3, np.nan)
    return truth.target_error(seen_target(sighting))


def _of(reduce: Any, values: np.ndarray) -> float:
    """Reduce the values that exist; NaN when none does."""
    values = values[np.isfinite(values)]
    return float(reduce(values)) if len(values) else np.nan


def _write_page(
    settings: DemoSettings, outcome: Outcome, summary: dict[str, Any], run: Run, measures: RunMeasures
) -> None:
    from bathbot_bringup.report.page import (
        write_page,
    )  # matplotlib takes a second: only when there is something to draw

    write_page(settings.out / "report.html", plain(summary), run, measures, outcome.epoch)
