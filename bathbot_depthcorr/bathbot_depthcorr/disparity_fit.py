"""Fits the disparity model: one robust Gauss-Newton for maps, ripple, extrinsics and wall planes.

The true disparity of a wall m.x = 1 (colour frame) along a depth ray r is f B (R' m . r) / (1 - m . t).
The model is linear in everything but the transform (R, t); the planes, known to the precision of the
chessboard only, are eliminated view by view. Priors: the factory's transform within 0.3 deg and 2 mm,
smooth maps, and a scale within 5 %; where the views say nothing, the maps stay with the factory.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.transform import Rotation

from bathbot_depthcorr.bspline_surface import SplineGrid
from bathbot_depthcorr.correction_model import CameraUnit
from bathbot_depthcorr.disparity_spline import DisparitySpline, ripple_terms
from bathbot_depthcorr.rigid import transform_from
from bathbot_depthcorr.views import CalibrationView, block_centres, block_means, block_size, wall_noise

Array = NDArray[np.float64]

ITERATIONS = 6
PRIOR_ROTATION = np.deg2rad(0.3)  # [rad] of the factory's depth -> colour transform
PRIOR_TRANSLATION = 2e-3  # [m]
PRIOR_SCALE = 0.05
PRIOR_OFFSET = 3.0  # [px]
PRIOR_RIPPLE = 0.03  # [px]
ROUGHNESS_OFFSET = 0.15  # [px] expected second difference of neighbouring coefficients
ROUGHNESS_SCALE = 0.003
LEAST_SIGMA = 0.005  # [px] of a block mean: keeps the priors alive on exact data
CORRELATED = 6.0  # neighbouring blocks err alike (texture, the maps' own grid): sigma counts so many times
GROSS = 6.0  # residuals beyond this many sigma are not the wall


class WallData(NamedTuple):
    """One view as rows of the fit, N usable blocks."""

    blocks: NDArray[np.intp]  # indices of the blocks, (N,)
    directions: Array  # depth rays, (N, 3)
    disparity: Array  # (N,) [px]
    ripple: Array  # (N, 4)
    plane: Array  # m of the wall in the colour frame, (3,)
    information: Array  # inverse covariance of m, (3, 3)


class Model(NamedTuple):
    """The state of the fit."""

    offset: Array
    scale: Array
    ripple: Array
    transform: Array


def fit_disparity_spline(views: Sequence[CalibrationView], unit: CameraUnit) -> DisparitySpline:
    """Fit the default correction.

    Args:
        views: Walls seen by the camera.
        unit: The camera, with the factory's depth -> colour transform.

    Returns:
        The correction; its `T_colour_depth` is the fitted transform.
    """
    fine = len(views) >= 18
    camera = unit.depth_camera
    offset_grid = SplineGrid(camera.width, camera.height, *((18, 11) if fine else (12, 8)))
    scale_grid = SplineGrid(camera.width, camera.height, *((6, 4) if fine else (5, 4)))
    fit = _Fit(unit, offset_grid, scale_grid)
    return fit.run([_wall_data(view, unit) for view in views], views)


def _wall_data(view: CalibrationView, unit: CameraUnit) -> WallData:
    camera, size = unit.depth_camera, block_size(unit.depth_camera)
    valid = view.depth > 0.0
    disparity = unit.focal_baseline / np.where(valid, view.depth, 1.0)
    grid = camera.pixel_grid()
    means = block_means(disparity, valid, size)
    used = np.flatnonzero(np.isfinite(means.ravel()))
    take = lambda values: block_means(values, valid, size).ravel()[used]  # noqa: E731
    pixels = np.stack([take(grid[..., 0]), take(grid[..., 1])], axis=-1)
    waves = ripple_terms(disparity)
    ripple = np.stack([take(waves[..., k]) for k in range(waves.shape[-1])], axis=-1)
    known = view.covariance + np.eye(3) * 1e-12
    return WallData(
        used,
        camera.directions(pixels),
        means.ravel()[used],
        ripple,
        view.plane.inverse_form,
        np.linalg.inv(known),
    )


class _Fit:
    """Gauss-Newton over offset, scale, ripple and transform; planes eliminated."""

    def __init__(self, unit: CameraUnit, offset_grid: SplineGrid, scale_grid: SplineGrid) -> None:
        self.unit, self.offset_grid, self.scale_grid = unit, offset_grid, scale_grid
        u, v = block_centres(unit.depth_camera)
        self.shape = (len(v), len(u))
        self.offset_basis, self.scale_basis = offset_grid.tensor(u, v), scale_grid.tensor(u, v)
        edges = np.cumsum([0, offset_grid.count, scale_grid.count, 4, 6])
        self.parts = [slice(a, b) for a, b in pairwise(edges)]
        self.prior = self._prior(edges[-1])

    def _prior(self, count: int) -> Array:
        offset, scale, ripple, motion = self.parts
        prior = np.zeros((count, count))
        prior[offset, offset] = self.offset_grid.roughness() / ROUGHNESS_OFFSET**2
        prior[scale, scale] = self.scale_grid.roughness() / ROUGHNESS_SCALE**2
        weak = np.zeros(count)
        weak[offset] = PRIOR_OFFSET**-2
        weak[scale] = PRIOR_SCALE**-2 / self.scale_grid.count
        weak[ripple] = PRIOR_RIPPLE**-2
        weak[motion] = np.repeat([PRIOR_ROTATION**-2, PRIOR_TRANSLATION**-2], 3)
        return prior + np.diag(weak)

    def run(self, walls: list[WallData], views: Sequence[CalibrationView]) -> DisparitySpline:
        """Iterate, then build the correction with its uncertainty."""
        state = np.zeros(len(self.prior))
        planes = [wall.plane for wall in walls]
        sigma, gate = 0.5, np.inf
        for _ in range(ITERATIONS):
            sigma, gate = self._spread(walls, planes, state, gate)
            state, planes, hessian = self._step(walls, planes, state, sigma)
        return self._correction(state, hessian, views)

    def model(self, state: Array) -> Model:
        """Unpack the state."""
        offset, scale, ripple, motion = (state[part] for part in self.parts)
        change = transform_from(Rotation.from_rotvec(motion[:3]).as_matrix())
        transform = change @ transform_from(self.unit.T_colour_depth[:3, :3])
        transform[:3, 3] = self.unit.T_colour_depth[:3, 3] + motion[3:]
        return Model(offset, scale, ripple, transform)

    def _residual(self, wall: WallData, plane: Array, model: Model) -> Array:
        truth, _, _ = _predict(wall.directions, plane, model.transform, self.unit.focal_baseline)
        scale = self.scale_basis[wall.blocks] @ model.scale
        bend = self.offset_basis[wall.blocks] @ model.offset + wall.ripple @ model.ripple
        return wall.disparity * (1.0 + scale) + bend - truth

    def _spread(
        self, walls: list[WallData], planes: list[Array], state: Array, gate: float
    ) -> tuple[float, float]:
        """Robust sigma of the residuals [px] and the gate within which the next one is measured."""
        model = self.model(state)
        residuals = np.concatenate([self._residual(w, m, model) for w, m in zip(walls, planes, strict=True)])
        inside = residuals[np.abs(residuals) < gate]
        sigma = max(LEAST_SIGMA, 1.4826 * float(np.median(np.abs(inside))))
        return sigma, GROSS * sigma

    def _step(
        self, walls: list[WallData], planes: list[Array], state: Array, sigma: float
    ) -> tuple[Array, list[Array], Array]:
        """One Gauss-Newton step; gives state, planes and the Hessian with the planes eliminated."""
        model = self.model(state)
        hessian, gradient = self.prior.copy(), self.prior @ state
        views = []
        for wall, plane in zip(walls, planes, strict=True):
            jacobian, to_plane = self._jacobians(wall, plane, model)
            residual = self._residual(wall, plane, model)
            size = np.abs(residual) / sigma
            weight = np.where(size < GROSS, np.minimum(1.0, 3.0 / np.maximum(size, 1e-9)), 0.0)
            weight /= (CORRELATED * sigma) ** 2
            own = (to_plane * weight[:, None]).T @ to_plane + wall.information
            cross = (to_plane * weight[:, None]).T @ jacobian
            own_gradient = to_plane.T @ (weight * residual) + wall.information @ (plane - wall.plane)
            solved = np.linalg.solve(own, np.column_stack([cross, own_gradient]))
            hessian += (jacobian * weight[:, None]).T @ jacobian - cross.T @ solved[:, :-1]
            gradient += jacobian.T @ (weight * residual) - cross.T @ solved[:, -1]
            views.append(solved)
        step = -cho_solve(cho_factor(hessian), gradient)
        moved = [
            plane - solved[:, -1] - solved[:, :-1] @ step for plane, solved in zip(planes, views, strict=True)
        ]
        return state + step, moved, hessian

    def _jacobians(self, wall: WallData, plane: Array, model: Model) -> tuple[Array, Array]:
        """Derivatives of the residual by the state, (N, count), and by the wall's m, (N, 3)."""
        focal_baseline = self.unit.focal_baseline
        truth, rotated, below = _predict(wall.directions, plane, model.transform, focal_baseline)
        by_rotation = rotated @ _cross_matrix(plane) * (focal_baseline / below)
        by_translation = np.outer(truth / below, plane)
        by_plane = rotated * (focal_baseline / below) + np.outer(truth / below, model.transform[:3, 3])
        jacobian = np.hstack([
            self.offset_basis[wall.blocks], self.scale_basis[wall.blocks] * wall.disparity[:, None],
            wall.ripple, -by_rotation, -by_translation,
        ])  # fmt: skip
        return jacobian, -by_plane

    def _correction(self, state: Array, hessian: Array, views: Sequence[CalibrationView]) -> DisparitySpline:
        model = self.model(state)
        offset, scale = self.parts[:2]
        covariance = np.linalg.inv(hessian)
        diagonal = lambda left, a, b, right: np.einsum("ij,jk,ik->i", left, covariance[a, b], right)  # noqa: E731
        variances = np.stack([
            diagonal(self.offset_basis, offset, offset, self.offset_basis),
            diagonal(self.offset_basis, offset, scale, self.scale_basis),
            diagonal(self.scale_basis, scale, scale, self.scale_basis),
        ]).reshape(3, *self.shape)  # fmt: skip
        unit = CameraUnit(
            self.unit.depth_camera,
            model.transform,
            self.unit.serial,
            self.unit.temperature,
            self.unit.baseline,
        )
        fitted = DisparitySpline(
            unit, model.scale.reshape(self.scale_grid.rows, -1),
            model.offset.reshape(self.offset_grid.rows, -1), model.ripple, 0.0, variances,
        )  # fmt: skip
        fitted.noise = wall_noise(fitted, views)
        return fitted


def _predict(
    directions: Array, plane: Array, transform: Array, focal_baseline: float
) -> tuple[Array, Array, float]:
    """True disparity (N,) [px], rays turned into the colour frame (N, 3), and 1 - m . t."""
    rotated = directions @ transform[:3, :3].T
    below = 1.0 - float(plane @ transform[:3, 3])
    return focal_baseline * (rotated @ plane) / below, rotated, below


def _cross_matrix(vector: Array) -> Array:
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
