"""Herrera, Kannala and Heikkila 2012, for a camera whose raw value is the disparity d = f B / Z of stereo.

    d_k = d + D(u, v) exp(a_0 - a_1 d),    Z' = 1 / (c_1 d_k + c_0)

The distortion map D, a_1, c_0, c_1, the transform and the walls' planes are fitted together, as published;
the paper alternates between D and the rest, here D is eliminated in each Gauss-Newton step, which ends at
the same minimum. What is chosen here, as the paper leaves it open or its sensor was another:

* D has one value per cell (8 px at 848 columns), bilinear in between; the paper has one per pixel, from many
  more pictures. Cells that no view saw take the value of the nearest one that was seen.
* D and exp(a_0) share a factor, so a_0 = a_1 times the mean disparity: D is the distortion there.
* Weak priors: D within 3 px (native), a_1 within 0.02 / px (native), scale within 5 %, offset within 3 px.

At distances never seen the formula holds on: scale and offset extrapolate as stereo does, the distortion by
its exponential.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.disparity_fit import PRIOR_OFFSET, PRIOR_SCALE
from bathbot_depthcorr.models.disparity_walls import Wall, wall_rows
from bathbot_depthcorr.views.views import CalibrationView
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from bathbot_bringup.evaluation.depth.measures import Depth, positive
from bathbot_bringup.evaluation.depth.methods.joint_fit import (
    Prediction,
    cell_shape,
    fit_jointly,
    spread_cells,
)

Array = NDArray[np.float64]

PRIOR_DECAY = 0.02  # [1/px native] of a_1
PRIOR_DISTORTION = 3.0  # [px native] of D
NATIVE_WIDTH = 1280


@dataclass(frozen=True, slots=True, eq=False)
class Herrera:
    """Herrera's formula, its symbols; `distortion` is D at each pixel [px], shape (H, W)."""

    T_colour_depth: Array
    focal_baseline: float
    distortion: Depth
    a: tuple[float, float]
    c: tuple[float, float]

    def apply(self, depth: Depth) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        a_0, a_1, c_0, c_1 = map(np.float32, (*self.a, *self.c))
        with np.errstate(divide="ignore", over="ignore"):
            disparity = np.float32(self.focal_baseline) / depth
            undistorted = disparity + self.distortion * np.exp(a_0 - a_1 * disparity)
            return positive(1.0 / (c_1 * undistorted + c_0))


def fit_herrera(views: Sequence[CalibrationView], unit: CameraUnit) -> Herrera:
    """Fit map, decay, scale, offset and transform together."""
    walls = [wall_rows(view, unit) for view in views]
    middle = float(np.mean(np.concatenate([wall.disparity for wall in walls])))
    seen = np.zeros(np.prod(cell_shape(unit)), dtype=bool)
    seen[np.concatenate([wall.blocks for wall in walls])] = True

    def model(wall: Wall, shared: Array, cells: Array) -> Prediction:
        decay, scale, offset = shared
        disparity = wall.disparity
        fading = np.exp(-decay * (disparity - middle))
        undistorted = disparity + cells * fading
        by_decay = -(1.0 + scale) * cells * fading * (disparity - middle)
        by_shared = np.stack([by_decay, undistorted, np.ones_like(disparity)], axis=-1)
        return Prediction(undistorted * (1.0 + scale) + offset, by_shared, (1.0 + scale) * fading)

    ratio = unit.depth_camera.width / NATIVE_WIDTH
    prior = np.array([PRIOR_DECAY / ratio, PRIOR_SCALE, PRIOR_OFFSET])
    fitted = fit_jointly(model, walls, unit, prior, PRIOR_DISTORTION * ratio)
    decay, scale, offset = fitted.shared.tolist()
    distortion = _filled(fitted.cells, seen.reshape(fitted.cells.shape))
    return Herrera(
        fitted.transform,
        unit.focal_baseline,
        spread_cells(distortion, unit),
        (decay * middle, decay),
        (offset / unit.focal_baseline, (1.0 + scale) / unit.focal_baseline),
    )


def _filled(values: Array, seen: NDArray[np.bool_]) -> Array:
    """Values, shape (h, w), with the nearest seen one where none was seen."""
    nearest = distance_transform_edt(~seen, return_distances=False, return_indices=True)
    return values[tuple(nearest)]
