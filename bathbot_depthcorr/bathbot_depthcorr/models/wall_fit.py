"""The solver behind the disparity models: one robust Gauss-Newton for a map, the extrinsics and the walls.

The true disparity of a wall m.x = 1 (colour frame) along a depth ray r is f B (R' m . r) / (1 - m . t). A
model adds to the raw disparity d something linear in its coefficients c, so that a block's residual is

    d + columns . c - f B (R' m . r) / (1 - m . t).

The walls, known to the precision of the chessboard only, are eliminated view by view. Priors: the factory's
transform within 0.3 deg and 2 mm, and whatever the model says of c.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg import block_diag, cho_factor, cho_solve
from scipy.spatial.transform import Rotation

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_depthcorr.models.disparity_walls import Wall

Array = NDArray[np.float64]

ITERATIONS = 6
PRIOR_ROTATION = np.deg2rad(0.3)  # [rad] of the factory's depth -> colour transform
PRIOR_TRANSLATION = 2e-3  # [m]
LEAST_SIGMA = 0.005  # [px] of a block mean: keeps the priors alive on exact data
CORRELATED = 6.0  # neighbouring blocks err alike (texture, the maps' own grid): sigma counts so many times
KNEE = 3.0  # Huber's, in sigma
GROSS = 6.0  # residuals beyond this many sigma are not the wall


class Columns(NamedTuple):
    """Sparse rows of a model's derivatives: P of K coefficients matter to a block.

    Attributes:
        index: Which coefficients, ascending along each row, shape (N, P).
        value: Derivatives of the corrected disparity by them, shape (N, P).
    """

    index: NDArray[np.intp]
    value: Array

    def times(self, coefficients: Array) -> Array:
        """Disparity [px] that coefficients, shape (K,), add, shape (N,)."""
        return np.sum(self.value * coefficients[self.index], axis=1)

    def quadratic(self, matrix: Array) -> Array:
        """Quadratic form of each row in a matrix, shape (K, K); shape (N,)."""
        near = matrix[self.index[:, :, None], self.index[:, None, :]]
        return np.einsum("ni,nij,nj->n", self.value, near, self.value)


def beside(*parts: Columns, counts: Sequence[int]) -> Columns:
    """Columns of maps side by side, each with its number of coefficients."""
    shifts = np.cumsum([0, *counts[:-1]])
    return Columns(
        np.hstack([part.index + shift for part, shift in zip(parts, shifts, strict=True)]),
        np.hstack([part.value for part in parts]),
    )


class Solution(NamedTuple):
    """What the fit found.

    Attributes:
        coefficients: Of the model, shape (K,).
        transform: Maps points of the depth frame to the colour frame, shape (4, 4).
        covariance: Of the coefficients, shape (K, K).
    """

    coefficients: Array
    transform: Array
    covariance: Array


def solve_walls(walls: Sequence[Wall], columns: Sequence[Array], prior: Array, unit: CameraUnit) -> Solution:
    """Fit a model that is linear in its coefficients.

    Args:
        walls: The views.
        columns: Of each wall.
        prior: Inverse covariance of the coefficients about zero, shape (K, K).
        unit: The camera, with the factory's transform.
    """
    motion = np.diag(np.repeat([PRIOR_ROTATION**-2, PRIOR_TRANSLATION**-2], 3))
    bundle = _Bundle(walls, columns, block_diag(prior, motion), unit)
    state, planes = np.zeros(len(bundle.prior)), [wall.plane for wall in walls]
    gate = np.inf
    for _ in range(ITERATIONS):
        sigma = bundle.spread(state, planes, gate)
        gate = GROSS * sigma
        state, planes, hessian = bundle.step(state, planes, sigma)
    count = len(prior)
    covariance = np.linalg.inv(hessian)[:count, :count]
    return Solution(state[:count], bundle.transform(state), covariance)


class WallSight(NamedTuple):
    """How the N blocks of a wall should look from a place.

    Attributes:
        disparity: True disparity [px], shape (N,).
        by_motion: Its derivatives by a turn [rad] and a shift [m] of the transform, shape (N, 6).
        by_plane: Its derivatives by the wall's m, shape (N, 3).
    """

    disparity: Array
    by_motion: Array
    by_plane: Array


def see_wall(wall: Wall, plane: Array, transform: Array, focal_baseline: float) -> WallSight:
    """Predict a wall m.x = 1 along the depth rays of its blocks.

    Args:
        wall: Its blocks.
        plane: m in the colour frame [1/m], shape (3,).
        transform: Depth -> colour, shape (4, 4).
        focal_baseline: f B [px m].
    """
    rotated = wall.directions @ transform[:3, :3].T
    below = 1.0 - float(plane @ transform[:3, 3])
    truth = focal_baseline * (rotated @ plane) / below
    by_rotation = np.cross(rotated, plane) * (focal_baseline / below)
    by_plane = rotated * (focal_baseline / below) + np.outer(truth / below, transform[:3, 3])
    return WallSight(truth, np.hstack([by_rotation, np.outer(truth / below, plane)]), by_plane)


def moved_transform(unit: CameraUnit, motion: Array) -> Array:
    """The factory's depth -> colour transform after a turn [rad] and a shift [m], shape (6,)."""
    turn = Rotation.from_rotvec(motion[:3]).as_matrix()
    return transform_from(turn @ unit.T_colour_depth[:3, :3], unit.T_colour_depth[:3, 3] + motion[3:])


def huber_weight(size: Array) -> Array:
    """Weights of residuals given in sigma; none for what is no wall."""
    return np.where(size < GROSS, np.minimum(1.0, KNEE / np.maximum(size, 1e-9)), 0.0)


class _Bundle:
    """The equations; a state is the coefficients, then a rotation vector [rad] and a translation [m]."""

    def __init__(
        self, walls: Sequence[Wall], columns: Sequence[Columns], prior: Array, unit: CameraUnit
    ) -> None:
        self.walls, self.columns, self.prior, self.unit = walls, columns, prior, unit

    def transform(self, state: Array) -> Array:
        """Depth -> colour."""
        return moved_transform(self.unit, state[-6:])

    def spread(self, state: Array, planes: Sequence[Array], gate: float) -> float:
        """Robust standard deviation [px] of the residuals within a gate [px]."""
        transform = self.transform(state)
        residuals = np.abs(np.concatenate([
            self._residual(number, plane, state, transform)[0] for number, plane in enumerate(planes)
        ]))  # fmt: skip
        return max(LEAST_SIGMA, 1.4826 * float(np.median(residuals[residuals < gate])))

    def step(self, state: Array, planes: Sequence[Array], sigma: float) -> tuple[Array, list[Array], Array]:
        """One Gauss-Newton step; gives state, planes and the Hessian with the planes eliminated."""
        transform = self.transform(state)
        hessian, gradient = self.prior.copy(), self.prior @ state
        views = []
        for number, (wall, plane) in enumerate(zip(self.walls, planes, strict=True)):
            residual, by_motion, by_plane = self._residual(number, plane, state, transform)
            weight = huber_weight(np.abs(residual) / sigma) / (CORRELATED * sigma) ** 2
            index, value = self._rows(number, by_motion)
            cross = np.zeros((3, len(state)))
            accumulate(index, value, weight, residual, by_plane, hessian, gradient, cross)
            own = (by_plane * weight[:, None]).T @ by_plane + wall.information
            own_gradient = by_plane.T @ (weight * residual) + wall.information @ (plane - wall.plane)
            solved = np.linalg.solve(own, np.column_stack([cross, own_gradient]))
            hessian -= cross.T @ solved[:, :-1]
            gradient -= cross.T @ solved[:, -1]
            views.append(solved)
        hessian = np.tril(hessian) + np.tril(hessian, -1).T
        step = -cho_solve(cho_factor(hessian), gradient)
        moved = [
            plane - solved[:, -1] - solved[:, :-1] @ step for plane, solved in zip(planes, views, strict=True)
        ]
        return state + step, moved, hessian

    def _rows(self, number: int, by_motion: Array) -> Columns:
        """The wall's columns with those of the motion behind them."""
        motion = np.broadcast_to(np.arange(6), by_motion.shape)
        counts = (len(self.prior) - 6, 6)
        return beside(self.columns[number], Columns(motion, by_motion), counts=counts)

    def _residual(
        self, number: int, plane: Array, state: Array, transform: Array
    ) -> tuple[Array, Array, Array]:
        """Residual [px], (N,), and its derivatives by the motion, (N, 6), and the wall's m, (N, 3)."""
        wall = self.walls[number]
        seen = see_wall(wall, plane, transform, self.unit.focal_baseline)
        residual = wall.disparity + self.columns[number].times(state) - seen.disparity
        return residual, -seen.by_motion, -seen.by_plane


@njit(cache=True, nogil=True)
def accumulate(index, value, weight, residual, by_plane, hessian, gradient, cross):
    """Add weighted rows to the lower triangle of J'WJ, to J'Wr and to P'WJ (P: derivatives by the plane)."""
    for n in range(index.shape[0]):
        for a in range(index.shape[1]):
            i = index[n, a]
            weighted = weight[n] * value[n, a]
            gradient[i] += weighted * residual[n]
            for k in range(3):
                cross[k, i] += by_plane[n, k] * weighted
            for b in range(a + 1):
                hessian[i, index[n, b]] += weighted * value[n, b]
