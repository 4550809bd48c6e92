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
from numpy.typing import NDArray
from scipy.linalg import block_diag, cho_factor, cho_solve
from scipy.spatial.transform import Rotation

from bathbot_depthcorr.correction_model import CameraUnit
from bathbot_depthcorr.disparity_walls import Wall
from bathbot_depthcorr.rigid import transform_from

Array = NDArray[np.float64]

ITERATIONS = 6
PRIOR_ROTATION = np.deg2rad(0.3)  # [rad] of the factory's depth -> colour transform
PRIOR_TRANSLATION = 2e-3  # [m]
LEAST_SIGMA = 0.005  # [px] of a block mean: keeps the priors alive on exact data
CORRELATED = 6.0  # neighbouring blocks err alike (texture, the maps' own grid): sigma counts so many times
KNEE = 3.0  # Huber's, in sigma
GROSS = 6.0  # residuals beyond this many sigma are not the wall


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
        columns: Derivative of each wall's corrected disparity by the coefficients, shape (N, K) each.
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


class _Bundle:
    """The equations; a state is the coefficients, then a rotation vector [rad] and a translation [m]."""

    def __init__(
        self, walls: Sequence[Wall], columns: Sequence[Array], prior: Array, unit: CameraUnit
    ) -> None:
        self.walls, self.columns, self.prior, self.unit = walls, columns, prior, unit

    def transform(self, state: Array) -> Array:
        """Depth -> colour."""
        factory = self.unit.T_colour_depth
        turn = Rotation.from_rotvec(state[-6:-3]).as_matrix()
        return transform_from(turn @ factory[:3, :3], factory[:3, 3] + state[-3:])

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
            jacobian = np.hstack([self.columns[number], by_motion])
            size = np.abs(residual) / sigma
            weight = np.where(size < GROSS, np.minimum(1.0, KNEE / np.maximum(size, 1e-9)), 0.0)
            weight /= (CORRELATED * sigma) ** 2
            weighted = jacobian * weight[:, None]
            own = (by_plane * weight[:, None]).T @ by_plane + wall.information
            cross = by_plane.T @ weighted
            own_gradient = by_plane.T @ (weight * residual) + wall.information @ (plane - wall.plane)
            solved = np.linalg.solve(own, np.column_stack([cross, own_gradient]))
            hessian += weighted.T @ jacobian - cross.T @ solved[:, :-1]
            gradient += weighted.T @ residual - cross.T @ solved[:, -1]
            views.append(solved)
        step = -cho_solve(cho_factor(hessian), gradient)
        moved = [
            plane - solved[:, -1] - solved[:, :-1] @ step for plane, solved in zip(planes, views, strict=True)
        ]
        return state + step, moved, hessian

    def _residual(
        self, number: int, plane: Array, state: Array, transform: Array
    ) -> tuple[Array, Array, Array]:
        """Residual [px], (N,), and its derivatives by the motion, (N, 6), and the wall's m, (N, 3)."""
        wall, focal_baseline = self.walls[number], self.unit.focal_baseline
        rotated = wall.directions @ transform[:3, :3].T
        below = 1.0 - float(plane @ transform[:3, 3])
        truth = focal_baseline * (rotated @ plane) / below
        residual = wall.disparity + self.columns[number] @ state[:-6] - truth
        by_rotation = rotated @ _cross_matrix(plane) * (focal_baseline / below)
        by_plane = rotated * (focal_baseline / below) + np.outer(truth / below, transform[:3, 3])
        return residual, np.hstack([-by_rotation, -np.outer(truth / below, plane)]), -by_plane


def _cross_matrix(vector: Array) -> Array:
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
