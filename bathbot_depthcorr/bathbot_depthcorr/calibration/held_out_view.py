"""Errors of a view that a fit did not see."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.quality import plane_rmse, z_accuracy
from bathbot_depthcorr.models.correction_model import Correction
from bathbot_depthcorr.views.views import CalibrationView, block_means, block_size, true_depth

QUANTILES = np.linspace(0.0, 1.0, 101)


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
    quantiles_before: NDArray[np.float64]  # of the absolute error, at QUANTILES
    quantiles_after: NDArray[np.float64]


def judge(view: CalibrationView, after: Correction, before: Correction) -> HeldOutView:
    """Errors of a view under two corrections, each with its own transform."""
    columns = zip(*(_errors(view, correction) for correction in (before, after)), strict=True)
    return HeldOutView(view.distance, *(value for pair in columns for value in pair))


def wall_error(view: CalibrationView, correction: Correction) -> tuple[NDArray, NDArray]:
    """Signed error [m] of a corrected view, NaN off the wall, and the truth [m], shape (H, W) each."""
    truth = true_depth(view, correction.unit)
    error = correction.apply(view.depth) - truth
    error[np.abs(error) > 0.1 * truth] = np.nan  # not the wall
    return error, truth


def _errors(view: CalibrationView, correction: Correction) -> tuple:
    camera = correction.depth_camera
    error, truth = wall_error(view, correction)
    accuracy = z_accuracy(truth + error, truth)
    points = camera.deproject(camera.pixel_grid()[::2, ::2], (truth + error)[::2, ::2])
    quantiles = np.nanquantile(np.abs(error[::2, ::2]), QUANTILES)
    blocks = block_means(error, np.isfinite(error), block_size(camera))
    return accuracy.signed, accuracy.absolute, plane_rmse(points), blocks, quantiles
