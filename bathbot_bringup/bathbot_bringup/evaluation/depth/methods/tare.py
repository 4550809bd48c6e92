"""Tare at one distance: a single offset of disparity, d' = d + o, as the maker's own tool adjusts it.

Only views near the tare distance count (that tool is meant for a target within about 20 % of one distance);
their walls are known from the chessboard. The transform stays the factory's: one number cannot tell an offset
of disparity from a shift of the camera. At other distances the same offset acts, which is all a tare can do.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.disparity_walls import wall_rows
from bathbot_depthcorr.views.views import CalibrationView, true_disparity
from numpy.typing import NDArray

from bathbot_bringup.evaluation.depth.measures import Depth, positive

TARE_DISTANCE = 0.75  # [m]
TARE_SPAN = 0.2  # relative


@dataclass(frozen=True, slots=True, eq=False)
class Tare:
    """Z' = Z / (1 + offset Z); offset is o / (f B) [1/m]."""

    T_colour_depth: NDArray[np.float64]
    offset: float

    def apply(self, depth: Depth) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        with np.errstate(divide="ignore"):
            return positive(depth / (1.0 + np.float32(self.offset) * depth))


def fit_tare(views: Sequence[CalibrationView], unit: CameraUnit) -> Tare:
    """Fit the offset to the views near the tare distance, or to the nearest one if there is none.

    It is the median over all cells of what the disparity lacks, so that a few flying pixels do no harm.
    """
    away = np.array([abs(view.distance / TARE_DISTANCE - 1.0) for view in views])
    near = [view for view, far in zip(views, away, strict=True) if far <= max(TARE_SPAN, away.min())]
    lacking = []
    for view in near:
        wall = wall_rows(view, unit)
        lacking.append(true_disparity(view, unit, wall.directions) - wall.disparity)
    return Tare(unit.T_colour_depth, float(np.median(np.concatenate(lacking))) / unit.focal_baseline)
