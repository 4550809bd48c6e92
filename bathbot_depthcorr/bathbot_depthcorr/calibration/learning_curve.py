"""How the error on held-out views falls with the number of views that were learnt from."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bathbot_depthcorr.calibration.held_out_view import wall_error
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Correction
from bathbot_depthcorr.models.table import Fit
from bathbot_depthcorr.views.views import CalibrationView, block_means, block_size

SIZES = (6, 9, 12, 15)  # numbers of views beside all; each costs a fit
PATCH = 4  # blocks along the edge of a patch


class LearningPoint(NamedTuple):
    """Number of views learnt from, and the mean absolute error of patches of the held-out ones [m]."""

    views: int
    error: float


def learning_curve(
    fit: Fit,
    training: Sequence[CalibrationView],
    held: Sequence[CalibrationView],
    unit: CameraUnit,
    progress: Callable[[float, str], None] = lambda share, detail: None,
) -> tuple[LearningPoint, ...]:
    """Fit to ever more of the training views, spread evenly over their distances.

    Args:
        fit: Makes a correction from views.
        training: Views to learn from, near to far.
        held: Views that no fit sees.
        unit: The camera.
        progress: Called with the share done, 0..1, and a few words.

    Returns:
        Few views first; the fit to all of them is left to the caller, who has it already.
    """
    sizes = [size for size in SIZES if size < len(training)]
    points = []
    for number, size in enumerate(sizes):
        progress(number / len(sizes), f"fit to {size} views")
        chosen = np.round(np.linspace(0, len(training) - 1, size)).astype(int)
        correction = fit([training[index] for index in chosen], unit)
        points.append(LearningPoint(size, smooth_error(correction, held)))
    return tuple(points)


def smooth_error(correction: Correction, views: Sequence[CalibrationView]) -> float:
    """Mean absolute error of a correction over patches of views [m], in which noise averages out."""
    size = PATCH * block_size(correction.depth_camera)
    errors = [wall_error(view, correction)[0] for view in views]
    patches = [np.abs(block_means(error, np.isfinite(error), size)) for error in errors]
    return float(np.nanmean(np.stack(patches)))
