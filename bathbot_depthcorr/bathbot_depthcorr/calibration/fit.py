"""Checks views, fits a correction to them, and judges it on views held out by pose."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bathbot_depthcorr.calibration.guards import (
    check_colour,
    check_coverage,
    check_extrinsics,
    check_parallax,
    check_views,
    extrinsics_change,
)
from bathbot_depthcorr.calibration.held_out_view import judge
from bathbot_depthcorr.calibration.learning_curve import LearningPoint, learning_curve, smooth_error
from bathbot_depthcorr.calibration.report import CalibrationReport
from bathbot_depthcorr.calibration.wall_extraction import only_wall
from bathbot_depthcorr.calibration.wall_guards import WallComparison, check_wall, compare_wall, keep_walls
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Correction, Identity
from bathbot_depthcorr.models.table import DEFAULT_MODEL, find_fit
from bathbot_depthcorr.views.colour_reference import ColourReference, ViewSet
from bathbot_depthcorr.views.views import CalibrationView, Steps, nearest_first

HELD_OUT_EVERY = 4


class CheckedViews(NamedTuple):
    """Views that passed every guard, cleaned of what is not the wall, near to far.

    Attributes:
        training: To learn from while judging.
        held: Held out, every fourth.
        unit: The camera.
        reference: See `ViewSet`.
        raw: Raw depth against the true planes.
        warnings: One line each.
    """

    training: list[CalibrationView]
    held: list[CalibrationView]
    unit: CameraUnit
    reference: ColourReference | None
    raw: WallComparison
    warnings: list[str]


def checked_views(found: ViewSet) -> CheckedViews:
    """Pass views through all guards.

    Raises:
        CalibrationRefusedError: Naming the number that failed.
    """
    unit, reference = found.unit, found.reference
    ordered, warnings = keep_walls(nearest_first(found.views), unit)
    warnings = [*found.notes, *warnings, *check_views(ordered)]
    if not unit.serial:
        warnings.append("the camera told no serial number on /diagnostics: any camera of this size will pass")
    warnings += check_colour(reference) if reference else []
    raw = compare_wall(ordered, unit)
    warnings += check_wall(raw)
    ordered, blind = keep_walls([only_wall(view, unit) for view in ordered], unit)
    warnings += blind + check_coverage(ordered, unit)
    held = set(range(HELD_OUT_EVERY // 2, len(ordered), HELD_OUT_EVERY))
    parts = [], []
    for index, view in enumerate(ordered):
        parts[index in held].append(view)
    return CheckedViews(*parts, unit, reference, raw, warnings)


def fit_and_judge(
    checked: CheckedViews, model: str, steps: Steps = Steps()
) -> tuple[Correction, CalibrationReport]:
    """Fit to the training views to judge, then to all views.

    Raises:
        CalibrationRefusedError: If the fitted transform cannot be that of the camera and the squares given.
    """
    fit, unit = find_fit(model), checked.unit
    every = nearest_first([*checked.training, *checked.held])
    steps.progress(0.0, f"fit to {len(checked.training)} views")
    trial = fit(checked.training, unit)
    steps.progress(0.5, f"fit to {len(every)} views")
    correction = fit(every, unit)
    warnings = [*checked.warnings, *check_extrinsics(correction.unit, unit)]
    # Only the default model knows the transform well enough to measure the squares by it.
    ruler = correction if model == DEFAULT_MODEL else find_fit(DEFAULT_MODEL)(every, unit)
    warnings += check_parallax(ruler.unit, unit)
    focal_change = checked.reference.focal_change if checked.reference else np.nan
    return correction, CalibrationReport(
        model, len(every), [judge(view, trial, Identity(unit)) for view in checked.held],
        extrinsics_change(correction.unit, unit), focal_change,
        correction.noise, checked.raw, warnings,
        (LearningPoint(len(checked.training), smooth_error(trial, checked.held)),),
    )  # fmt: skip


def calibrate(
    views: Sequence[CalibrationView],
    unit: CameraUnit,
    model: str = DEFAULT_MODEL,
    reference: ColourReference | None = None,
) -> tuple[Correction, CalibrationReport]:
    """Fit a correction and judge it on views held out by pose.

    Args:
        views: Walls seen by the camera.
        unit: The camera, with the factory's depth -> colour transform.
        model: One of `MODELS`.
        reference: What the board says about the colour camera, if it was used.

    Returns:
        The correction fitted to all views, and the report of one fitted without the held-out views.

    Raises:
        SettingsError: On an unknown model.
        CalibrationRefusedError: Naming the number that failed.
    """
    find_fit(model)
    return fit_and_judge(checked_views(ViewSet(list(views), unit, reference)), model)


def with_learning(report: CalibrationReport, checked: CheckedViews, steps: Steps) -> CalibrationReport:
    """The report with the learning curve from fewer views on: a few more fits."""
    points = learning_curve(
        find_fit(report.model), checked.training, checked.held, checked.unit, steps.progress
    )
    return report._replace(learning=(*points, *report.learning))
