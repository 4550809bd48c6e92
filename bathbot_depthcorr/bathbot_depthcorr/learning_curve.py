"""How the error on held-out views falls with the number of views that were learnt from."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bathbot_depthcorr.correction_model import CameraUnit, Correction
from bathbot_depthcorr.quality import z_accuracy
from bathbot_depthcorr.views import CalibrationView, true_depth

SIZES = (6, 9, 12, 15, 18)  # numbers of views; each costs a fit
Fit = Callable[[Sequence[CalibrationView], CameraUnit], Correction]


class LearningPoint(NamedTuple):
    """Number of views learnt from, and the mean absolute error on the held-out ones [m]."""

    views: int
    error: float


def learning_curve(
    fit: Fit,
    training: Sequence[CalibrationView],
    held: Sequence[CalibrationView],
    unit: CameraUnit,
    progress: Callable[[float, str], None] = lambda share, detail: None,
) -> tuple[LearningPoint, ...]:
    """Fit to fewer and fewer of the training views, spread evenly over their distances.

    Args:
        fit: Makes a correction from views.
        training: Views to learn from, near to far.
        held: Views that no fit sees.
        unit: The camera.
        progress: Called with the share done, 0..1, and a few words.
    """
    sizes = [size for size in SIZES if size < len(training)]
    points = []
    for number, size in enumerate(sizes):
        progress(number / len(sizes), f"fit to {size} views")
        chosen = np.round(np.linspace(0, len(training) - 1, size)).astype(int)
        correction = fit([training[index] for index in chosen], unit)
        points.append(LearningPoint(size, mean_error(correction, held)))
    return tuple(points)


def mean_error(correction: Correction, views: Sequence[CalibrationView]) -> float:
    """Mean absolute error of a correction over views [m]."""
    errors = []
    for view in views:
        depth, truth = correction.apply(view.depth), true_depth(view, correction.unit)
        wall = np.abs(depth - truth) <= 0.1 * truth
        errors.append(z_accuracy(np.where(wall, depth, np.nan), truth).absolute)
    return float(np.mean(errors))
