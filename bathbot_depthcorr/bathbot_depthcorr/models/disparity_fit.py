"""Fits the default model: smooth maps of scale and offset of disparity, and the ripple.

Priors: smooth maps, a scale within 5 %, an offset within 3 px; where the views say nothing, the maps stay
with the factory.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from bathbot_depthcorr.geometry.bspline_surface import SplineGrid
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.disparity_spline import DisparitySpline
from bathbot_depthcorr.models.disparity_walls import Wall, wall_noise, wall_rows
from bathbot_depthcorr.models.ripple import TERMS
from bathbot_depthcorr.models.wall_fit import Columns, beside, solve_walls
from bathbot_depthcorr.views.views import CalibrationView, block_centres

Array = NDArray[np.float64]

PRIOR_SCALE = 0.05
PRIOR_OFFSET = 3.0  # [px]
PRIOR_RIPPLE = 0.03  # [px]
ROUGHNESS_OFFSET = 0.15  # [px] expected second difference of neighbouring coefficients
ROUGHNESS_SCALE = 0.003
OFFSET_SIZE, SCALE_SIZE = (32, 18), (12, 8)  # columns, rows; smoothness, not size, holds few views in check


def fit_disparity_spline(views: Sequence[CalibrationView], unit: CameraUnit) -> DisparitySpline:
    """Fit the default correction.

    Args:
        views: Walls seen by the camera.
        unit: The camera, with the factory's depth -> colour transform.

    Returns:
        The correction; its `T_colour_depth` is the fitted transform.
    """
    camera = unit.depth_camera
    offset_grid = SplineGrid(camera.width, camera.height, *OFFSET_SIZE)
    scale_grid = SplineGrid(camera.width, camera.height, *SCALE_SIZE)
    walls = [wall_rows(view, unit) for view in views]
    columns = [_columns(offset_grid, scale_grid, wall) for wall in walls]
    prior = block_diag(
        smoothness(offset_grid, ROUGHNESS_OFFSET, PRIOR_OFFSET),
        smoothness(scale_grid, ROUGHNESS_SCALE, PRIOR_SCALE * np.sqrt(scale_grid.count)),
        np.eye(TERMS) * PRIOR_RIPPLE**-2,
    )
    found = solve_walls(walls, columns, prior, unit)
    parts = np.split(found.coefficients, np.cumsum([offset_grid.count, scale_grid.count]))
    fitted = DisparitySpline(
        replace(unit, T_colour_depth=found.transform),
        parts[1].reshape(scale_grid.rows, -1),
        parts[0].reshape(offset_grid.rows, -1),
        parts[2],
        0.0,
        _variances(found.covariance, offset_grid, scale_grid, unit),
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


def _columns(offset_grid: SplineGrid, scale_grid: SplineGrid, wall: Wall) -> Columns:
    """Derivatives of o + s d + ripple."""
    offset, scale = (Columns(*grid.local(wall.pixels)) for grid in (offset_grid, scale_grid))
    scaled = Columns(scale.index, scale.value * wall.disparity[:, None])
    return beside(offset, scaled, ripple_columns(wall), counts=(offset_grid.count, scale_grid.count, TERMS))


def ripple_columns(wall: Wall) -> Columns:
    """Derivatives by the ripple's amplitudes."""
    return Columns(np.broadcast_to(np.arange(TERMS), wall.ripple.shape), wall.ripple)


def _variances(covariance: Array, offset_grid: SplineGrid, scale_grid: SplineGrid, unit: CameraUnit) -> Array:
    """Var(o), Cov(o, s) and Var(s) at every block, shape (3, h, w)."""
    u, v = block_centres(unit.depth_camera)
    (across_o, down_o), (across_s, down_s) = offset_grid.basis(u, v), scale_grid.basis(u, v)
    offset, scale = np.kron(down_o, across_o), np.kron(down_s, across_s)
    first = slice(offset_grid.count)
    second = slice(offset_grid.count, offset_grid.count + scale_grid.count)
    return np.reshape([
        np.sum(offset @ covariance[first, first] * offset, axis=1),
        np.sum(offset @ covariance[first, second] * scale, axis=1),
        np.sum(scale @ covariance[second, second] * scale, axis=1),
    ], (3, len(v), len(u)))  # fmt: skip
