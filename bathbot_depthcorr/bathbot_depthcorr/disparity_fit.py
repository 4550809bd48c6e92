"""Fits the default model: smooth maps of scale and offset of disparity, and the ripple.

Priors: smooth maps, a scale within 5 %, an offset within 3 px; where the views say nothing, the maps stay
with the factory.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from bathbot_depthcorr.bspline_surface import SplineGrid
from bathbot_depthcorr.correction_model import CameraUnit
from bathbot_depthcorr.disparity_spline import DisparitySpline
from bathbot_depthcorr.disparity_walls import wall_rows
from bathbot_depthcorr.ripple import TERMS
from bathbot_depthcorr.views import CalibrationView, block_centres, wall_noise
from bathbot_depthcorr.wall_fit import solve_walls

Array = NDArray[np.float64]

PRIOR_SCALE = 0.05
PRIOR_OFFSET = 3.0  # [px]
PRIOR_RIPPLE = 0.03  # [px]
ROUGHNESS_OFFSET = 0.15  # [px] expected second difference of neighbouring coefficients
ROUGHNESS_SCALE = 0.003
FINE_VIEWS = 18  # from so many views on, finer maps are worth their coefficients


def fit_disparity_spline(views: Sequence[CalibrationView], unit: CameraUnit) -> DisparitySpline:
    """Fit the default correction.

    Args:
        views: Walls seen by the camera.
        unit: The camera, with the factory's depth -> colour transform.

    Returns:
        The correction; its `T_colour_depth` is the fitted transform.
    """
    camera, fine = unit.depth_camera, len(views) >= FINE_VIEWS
    offset_grid = SplineGrid(camera.width, camera.height, *((18, 11) if fine else (12, 8)))
    scale_grid = SplineGrid(camera.width, camera.height, *((6, 4) if fine else (5, 4)))
    u, v = block_centres(camera)
    offset, scale = offset_grid.tensor(u, v), scale_grid.tensor(u, v)
    walls = [wall_rows(view, unit) for view in views]
    columns = [
        np.hstack([offset[wall.blocks], scale[wall.blocks] * wall.disparity[:, None], wall.ripple])
        for wall in walls
    ]
    prior = block_diag(
        smoothness(offset_grid, ROUGHNESS_OFFSET, PRIOR_OFFSET),
        smoothness(scale_grid, ROUGHNESS_SCALE, PRIOR_SCALE * np.sqrt(scale_grid.count)),
        np.eye(TERMS) * PRIOR_RIPPLE**-2,
    )
    found = solve_walls(walls, columns, prior, unit)
    parts = np.split(found.coefficients, np.cumsum([offset_grid.count, scale_grid.count]))
    variances = _variances(found.covariance, offset, scale).reshape(3, len(v), len(u))
    fitted = DisparitySpline(
        replace(unit, T_colour_depth=found.transform),
        parts[1].reshape(scale_grid.rows, -1),
        parts[0].reshape(offset_grid.rows, -1),
        parts[2],
        0.0,
        variances,
    )
    fitted.noise = wall_noise(fitted, views)
    return fitted


def smoothness(grid: SplineGrid, roughness: float, size: float) -> Array:
    """Inverse covariance, shape (count, count), of a map's coefficients.

    Args:
        grid: Of the map.
        roughness: Expected second difference of neighbouring coefficients.
        size: Expected size of a coefficient.
    """
    return grid.roughness() / roughness**2 + np.eye(grid.count) * size**-2.0


def _variances(covariance: Array, offset: Array, scale: Array) -> Array:
    """Var(o), Cov(o, s) and Var(s) at every block, shape (3, blocks)."""
    first = slice(offset.shape[1])
    second = slice(offset.shape[1], offset.shape[1] + scale.shape[1])
    across = offset @ covariance[first, second]
    return np.stack([
        np.sum(offset @ covariance[first, first] * offset, axis=1),
        np.sum(across * scale, axis=1),
        np.sum(scale @ covariance[second, second] * scale, axis=1),
    ])  # fmt: skip
