"""One quadratic for the whole image, Z' = a + b Z + c Z^2, fitted together with the transform.

Beyond the distances of the views the same polynomial continues.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.disparity_walls import Wall, wall_rows
from bathbot_depthcorr.views.views import CalibrationView
from numpy.typing import NDArray

from bathbot_bringup.evaluation.depth.measures import Depth, positive
from bathbot_bringup.evaluation.depth.methods.joint_fit import Prediction, fit_jointly

Array = NDArray[np.float64]

IDENTITY = np.array([0.0, 1.0, 0.0])
PRIOR = np.array([0.05, 0.1, 0.1])  # standard deviations of a [m], b - 1 and c [1/m]: weak, the views decide


@dataclass(frozen=True, slots=True, eq=False)
class GlobalQuadratic:
    """Z' = a + b Z + c Z^2; `coefficients` are a [m], b, c [1/m]."""

    T_colour_depth: Array
    coefficients: Array

    def apply(self, depth: Depth) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        a, b, c = self.coefficients.astype(np.float32)
        return positive(a + depth * (b + depth * c))


def fit_global_quadratic(views: Sequence[CalibrationView], unit: CameraUnit) -> GlobalQuadratic:
    """Fit the quadratic and the transform."""

    def model(wall: Wall, shared: Array, cells: Array) -> Prediction:
        depth = unit.focal_baseline / wall.disparity
        powers = np.stack([np.ones_like(depth), depth, depth**2], axis=-1)
        corrected = depth + powers @ shared
        return Prediction(
            unit.focal_baseline / corrected,
            -powers * (unit.focal_baseline / corrected**2)[:, None],
            np.zeros_like(cells),
        )

    fitted = fit_jointly(model, [wall_rows(view, unit) for view in views], unit, PRIOR, 1.0)
    return GlobalQuadratic(fitted.transform, IDENTITY + fitted.shared)
