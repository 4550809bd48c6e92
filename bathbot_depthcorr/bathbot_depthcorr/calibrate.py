"""From views, or a recorded bag, to a correction and a report that lets one believe it."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.bag_views import read_boards
from bathbot_depthcorr.chessboard import Chessboard
from bathbot_depthcorr.colour_reference import ColourReference, views_from_boards
from bathbot_depthcorr.correction import MODELS
from bathbot_depthcorr.correction_model import CalibrationFileError, CameraUnit, Correction, Identity
from bathbot_depthcorr.disparity_fit import fit_disparity_spline
from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.guards import (
    check_colour,
    check_extrinsics,
    check_views,
    check_wall,
    extrinsics_change,
)
from bathbot_depthcorr.quality import plane_rmse, z_accuracy
from bathbot_depthcorr.two_stage_fit import fit_two_stage
from bathbot_depthcorr.views import CalibrationView, block_means, block_size, nearest_first, true_depth
from bathbot_depthcorr.wall_extraction import only_wall

DEFAULT_MODEL = "disparity_spline"
HELD_OUT_EVERY = 4
_FITS: dict[str, Callable[[Sequence[CalibrationView], CameraUnit], Correction]] = {
    "disparity_spline": fit_disparity_spline,
    "two_stage": fit_two_stage,
    "identity": lambda _, unit: Identity(unit),
}


class HeldOutView(NamedTuple):
    """Errors of one view that the fit did not see, all [m]; `before` uses the factory's transform."""

    distance: float
    signed_before: float
    signed_after: float
    absolute_before: float
    absolute_after: float
    rmse_before: float
    rmse_after: float
    residual_before: NDArray[np.float64]  # block means, shape (h, w)
    residual_after: NDArray[np.float64]


class CalibrationReport(NamedTuple):
    """What a calibration found; `lines` says it in words.

    Attributes:
        model: Name of the model.
        views: Number of views used, held-out ones included.
        held_out: Errors on held-out views, near to far.
        turn: Of the depth -> colour transform against the factory's [rad].
        move: The same [m].
        focal_change: Focal length of the colour camera from the board against the factory's, relative.
        frame_noise: Of disparity, one pixel of one frame [px].
        warnings: One line each.
    """

    model: str
    views: int
    held_out: list[HeldOutView]
    turn: float
    move: float
    focal_change: float
    frame_noise: float
    warnings: list[str]

    @property
    def before(self) -> float:
        """Mean absolute error of raw depth on held-out views [m]."""
        return float(np.mean([view.absolute_before for view in self.held_out]))

    @property
    def after(self) -> float:
        """Mean absolute error of corrected depth on held-out views [m]."""
        return float(np.mean([view.absolute_after for view in self.held_out]))

    def lines(self) -> list[str]:
        """The report in words, one line each."""
        table = [
            f"  {view.distance:5.2f} m"
            f"   {view.absolute_before * 1e3:7.2f} -> {view.absolute_after * 1e3:5.2f} mm"
            f"   signed {view.signed_before * 1e3:+7.2f} -> {view.signed_after * 1e3:+5.2f} mm"
            f"   plane RMSE {view.rmse_before * 1e3:5.2f} -> {view.rmse_after * 1e3:5.2f} mm"
            for view in self.held_out
        ]
        return [
            f"model {self.model}, {self.views} views, {len(self.held_out)} of them held out for this table",
            "mean absolute error before -> after:", *table,
            f"mean {self.before * 1e3:.2f} -> {self.after * 1e3:.2f} mm",
            f"depth -> colour: {np.rad2deg(self.turn):.3f} deg, {self.move * 1e3:.2f} mm from the factory's",
            f"colour focal length from the board: {self.focal_change:+.3%} against the factory's",
            *(f"warning: {warning}" for warning in self.warnings),
        ]  # fmt: skip


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
    if model not in _FITS:
        raise SettingsError(f"unknown depth model {model!r}; known are {', '.join(MODELS)}")
    ordered = nearest_first(views)
    warnings = check_views(ordered)
    warnings += check_colour(reference) if reference else []
    warnings += check_wall(ordered, unit)
    ordered = [only_wall(view, unit) for view in ordered]
    held = ordered[HELD_OUT_EVERY // 2 :: HELD_OUT_EVERY]
    rest = [view for view in ordered if all(view is not other for other in held)]
    trial = _FITS[model](rest, unit)
    correction = _FITS[model](ordered, unit)
    warnings += check_extrinsics(correction.unit, unit)
    errors = [judge(view, trial, Identity(unit)) for view in held]
    turn, move = extrinsics_change(correction.unit, unit)
    report = CalibrationReport(
        model, len(ordered), errors, turn, move, reference.focal_change if reference else 0.0,
        float(getattr(correction, "noise", np.nan)), warnings,
    )  # fmt: skip
    return correction, report


def judge(view: CalibrationView, after: Correction, before: Correction) -> HeldOutView:
    """Errors of a view under two corrections, each with its own transform."""
    signed, absolute, rmse, residual = zip(
        *(_errors(view, correction) for correction in (before, after)), strict=True
    )
    return HeldOutView(view.distance, *signed, *absolute, *rmse, *residual)


def _errors(view: CalibrationView, correction: Correction) -> tuple[float, float, float, NDArray[np.float64]]:
    camera = correction.depth_camera
    depth, truth = correction.apply(view.depth), true_depth(view, correction.unit)
    error = depth - truth
    error[np.abs(error) > 0.1 * truth] = np.nan  # not the wall
    accuracy = z_accuracy(truth + error, truth)
    points = camera.deproject(camera.pixel_grid()[::2, ::2], (truth + error)[::2, ::2])
    blocks = block_means(error, np.isfinite(error), block_size(camera))
    return accuracy.signed, accuracy.absolute, plane_rmse(points), blocks


def calibrate_bag(
    bag: Path,
    out: Path,
    model: str = DEFAULT_MODEL,
    board: tuple[int, int] = (11, 8),
    square: float = 0.05,
    progress: Callable[[str], None] | None = None,
) -> CalibrationReport:
    """Make a correction from a recorded bag and write it, with its picture beside it (`out` as .png).

    Args:
        bag: A rosbag2 bag with the raw topics of the camera.
        out: Where to write the .npz file; nothing is written unless all went well.
        model: One of `MODELS`.
        board: Inner corners along and across.
        square: Edge of a square [m].
        progress: Called with one line per step.

    Raises:
        DepthcorrError: In one line, on a bag, board or views that do not serve.
    """
    tell = progress or (lambda _: None)
    if model not in _FITS:
        raise SettingsError(f"unknown depth model {model!r}; known are {', '.join(MODELS)}")
    out = Path(out)
    if not out.parent.is_dir():
        raise CalibrationFileError(
            f"folder {out.parent} does not exist; create it or choose another for {out.name}"
        )
    if out.suffix != ".npz":
        raise SettingsError(f"the calibration file must end in .npz, got {out.name}")
    chessboard = Chessboard(*board, square)
    recording = read_boards(Path(bag), chessboard, tell)
    views, reference = views_from_boards(recording.boards, chessboard, recording.colour_camera)
    tell(f"fitting {model} to {len(views)} views")
    correction, report = calibrate(views, recording.unit, model, reference)
    correction.save(out)
    from bathbot_depthcorr.calibration_plots import save_plots  # matplotlib only where it is wanted

    save_plots(report, out.with_suffix(".png"))
    tell(f"wrote {out}")
    return report
