"""Fits the paper's two stages (2.1.2, Fig. 4): f_i from near to far, then f_g together with the transform.

Stage one corrects each cloud with the f_i known so far, fits a plane to it, and adds to every cell one
sample: the depth at which its ray meets that plane. Stage two moves the flattened walls onto the planes
of the chessboard. The paper gives no cell size, degree, weights or form of f_g; here cells are 8 px wide
(at 848 columns), both functions are quadratic, and samples weigh 1 / Z^4, as stereo noise demands. A weak
prior holds cells to the identity where they have seen little.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.plane import fit_plane
from bathbot_depthcorr.models.disparity_walls import wall_noise
from bathbot_depthcorr.models.two_stage import TwoStage, make_monotone
from bathbot_depthcorr.models.wall_fit import PRIOR_ROTATION, PRIOR_TRANSLATION
from bathbot_depthcorr.views.views import CalibrationView, block_means, block_size, nearest_first

Array = NDArray[np.float64]

PRIOR_LOCAL = np.array([0.02, 0.05, 0.05])  # standard deviations of a_0 [m], a_1, a_2 [1/m]
PRIOR_OVERALL = np.array([0.01, 0.05, 0.05])
CELL_NOISE = 0.06  # [px] of disparity, mean of a cell
IDENTITY = np.array([0.0, 1.0, 0.0])


def fit_two_stage(views: Sequence[CalibrationView], unit: CameraUnit) -> TwoStage:
    """Fit the paper's correction.

    Args:
        views: Walls seen by the camera.
        unit: The camera, with the factory's depth -> colour transform.

    Returns:
        The correction; its `T_colour_depth` is the fitted transform.
    """
    ordered = nearest_first(views)
    clouds = [_cells(view, unit) for view in ordered]
    seen = np.concatenate([depth[np.isfinite(depth)] for depth, _ in clouds])
    span = (float(np.percentile(seen, 0.5)), float(np.percentile(seen, 99.5)))
    local = _flatten(clouds, unit)
    flat = [(_polynomial(make_monotone(local, *span), depth), rays) for depth, rays in clouds]
    overall, transform = _align(flat, ordered, unit)
    fitted_unit = CameraUnit(unit.depth_camera, transform, unit.serial, unit.temperature, unit.baseline)
    fitted = TwoStage(fitted_unit, local, overall, span, 0.0)
    fitted.noise = wall_noise(fitted, ordered)
    return fitted


def _cells(view: CalibrationView, unit: CameraUnit) -> tuple[Array, Array]:
    """Depth of each cell [m], shape (h, w), NaN = none, and its ray, shape (h, w, 3)."""
    camera, size = unit.depth_camera, block_size(unit.depth_camera)
    valid = view.depth > 0.0
    grid = camera.pixel_grid()
    depth = 1.0 / block_means(1.0 / np.where(valid, view.depth, 1.0), valid, size)
    pixels = np.stack([block_means(grid[..., axis], valid, size) for axis in (0, 1)], axis=-1)
    return depth, camera.directions(pixels)


def _polynomial(coefficients: Array, depth: Array) -> Array:
    return coefficients[..., 0] + depth * (coefficients[..., 1] + depth * coefficients[..., 2])


def _flatten(clouds: list[tuple[Array, Array]], unit: CameraUnit) -> Array:
    """Stage one: coefficients of f_i, shape (h, w, 3), from clouds ordered near to far."""
    shape = clouds[0][0].shape
    normal = np.broadcast_to(np.diag(PRIOR_LOCAL**-2.0), (*shape, 3, 3)).copy()
    right = normal @ IDENTITY
    local = np.broadcast_to(IDENTITY, (*shape, 3))
    for depth, rays in clouds:
        wall = fit_plane(rays * _polynomial(local, depth)[..., None], robust=True)
        target = wall.depth_along(rays)
        sigma = CELL_NOISE * depth**2 / unit.focal_baseline
        usable = np.isfinite(depth) & (np.abs(target - _polynomial(local, depth)) < 0.05 * depth)
        weight = np.where(usable, sigma**-2.0, 0.0)
        powers = np.where(usable[..., None], np.stack([np.ones(shape), depth, depth**2], axis=-1), 0.0)
        normal = normal + (weight[..., None, None] * powers[..., :, None]) * powers[..., None, :]
        right = right + (weight * np.where(usable, target, 0.0))[..., None] * powers
        local = np.linalg.solve(normal, right[..., None])[..., 0]
    return local


def _align(
    flat: list[tuple[Array, Array]], views: Sequence[CalibrationView], unit: CameraUnit
) -> tuple[Array, Array]:
    """Stage two: f_g, shape (3,), and the depth -> colour transform, shape (4, 4), together."""
    coarse = (slice(2, None, 5), slice(2, None, 5))
    samples = []
    for (depth, rays), view in zip(flat, views, strict=True):
        depth, rays = depth[coarse], rays[coarse]
        keep = np.isfinite(depth)
        samples.append((depth[keep], rays[keep], view.plane))

    def unpack(state: Array) -> tuple[Array, Array]:
        transform = np.array(unit.T_colour_depth, dtype=float)
        transform[:3, :3] = Rotation.from_rotvec(state[3:6]).as_matrix() @ transform[:3, :3]
        transform[:3, 3] += state[6:]
        return IDENTITY + state[:3], transform

    def residuals(state: Array) -> Array:
        overall, transform = unpack(state)
        back = np.linalg.inv(transform)
        rows = []
        for depth, rays, plane in samples:
            truth = plane.transformed(back).depth_along(rays)
            sigma = CELL_NOISE * depth**2 / unit.focal_baseline
            rows.append(np.nan_to_num((_polynomial(overall, depth) - truth) / sigma, nan=10.0))
        return np.concatenate(rows)

    prior = np.concatenate([PRIOR_OVERALL, np.full(3, PRIOR_ROTATION), np.full(3, PRIOR_TRANSLATION)])

    def with_prior(state: Array) -> Array:
        left = residuals(state)
        return np.concatenate([np.sign(left) * np.sqrt(_huber(left)), state / prior])

    solution = least_squares(with_prior, np.zeros(9), x_scale=prior, max_nfev=40, method="trf")
    return unpack(solution.x)


def _huber(residual: Array, knee: float = 3.0) -> Array:
    size = np.abs(residual)
    return np.where(size < knee, size**2, 2.0 * knee * size - knee**2)
