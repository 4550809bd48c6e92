"""Fits the two-imager model; priors as in `disparity_fit`.

What both maps have in common with each other and with the scale - a constant, a slope along u - the views
tell apart but weakly. A ridge on the right imager's map decides in favour of the left one.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from bathbot_depthcorr.geometry.bspline_surface import SplineGrid
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.disparity_fit import (
    OFFSET_SIZE,
    PRIOR_OFFSET,
    PRIOR_RIPPLE,
    PRIOR_SCALE,
    ROUGHNESS_OFFSET,
    ripple_columns,
    smoothness,
)
from bathbot_depthcorr.models.disparity_walls import wall_noise, wall_rows
from bathbot_depthcorr.models.ripple import TERMS
from bathbot_depthcorr.models.two_imager import TwoImager, widest_disparity
from bathbot_depthcorr.models.wall_fit import Columns, beside, solve_walls
from bathbot_depthcorr.views.views import CalibrationView, block_centres

Array = NDArray[np.float64]

PRIOR_RIGHT = 0.3  # [px]
LEVELS = 6  # disparities at which the doubt of the maps is kept


def fit_two_imager(views: Sequence[CalibrationView], unit: CameraUnit) -> TwoImager:
    """Fit one map per imager.

    Args:
        views: Walls seen by the camera.
        unit: The camera, with the factory's depth -> colour transform.

    Returns:
        The correction; its `T_colour_depth` is the fitted transform.
    """
    camera = unit.depth_camera
    grid = SplineGrid(camera.width, camera.height, *OFFSET_SIZE)
    walls = [wall_rows(view, unit) for view in views]
    columns = [
        beside(
            _columns(grid, wall.pixels, wall.disparity),
            ripple_columns(wall),
            counts=(2 * grid.count + 1, TERMS),
        )
        for wall in walls
    ]
    prior = block_diag(
        smoothness(grid, ROUGHNESS_OFFSET, PRIOR_OFFSET),
        smoothness(grid, ROUGHNESS_OFFSET, PRIOR_RIGHT),
        PRIOR_SCALE**-2,
        np.eye(TERMS) * PRIOR_RIPPLE**-2,
    )
    found = solve_walls(walls, columns, prior, unit)
    parts = np.split(found.coefficients, np.cumsum([grid.count, grid.count, 1]))
    fitted = TwoImager(
        replace(unit, T_colour_depth=found.transform),
        parts[2][0],
        parts[0].reshape(grid.rows, -1),
        parts[1].reshape(grid.rows, -1),
        parts[3],
        0.0,
        _variances(found.covariance, grid, unit),
    )
    fitted.noise = wall_noise(fitted, views)
    return fitted


def _columns(grid: SplineGrid, pixels: Array, disparity: Array) -> Columns:
    """Derivatives of l(u, v) - r(u - d, v) + s d at pixels (u, v), shape (N, 2)."""
    matched = np.column_stack([np.clip(pixels[:, 0] - disparity, 0.0, grid.width - 1.0), pixels[:, 1]])
    left, right = Columns(*grid.local(pixels)), Columns(*grid.local(matched))
    scale = Columns(np.zeros((len(pixels), 1), dtype=np.intp), disparity[:, None])
    return beside(left, Columns(right.index, -right.value), scale, counts=(grid.count, grid.count, 1))


def _variances(covariance: Array, grid: SplineGrid, unit: CameraUnit) -> Array:
    """Variance of the corrected disparity [px^2] at `LEVELS` disparities, on the blocks' grid."""
    u, v = block_centres(unit.depth_camera)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
    count = 2 * grid.count + 1
    levels = []
    for disparity in np.linspace(0.0, widest_disparity(grid.width), LEVELS):
        shift = np.full(len(pixels), disparity)
        levels.append(_columns(grid, pixels, shift).quadratic(covariance[:count, :count]))
    return np.reshape(levels, (LEVELS, len(v), len(u)))
