"""A baseline's parameters fitted together with the depth -> colour transform and the walls' planes.

One robust Gauss-Newton for all baselines that the literature fits jointly; their models are not linear in
their parameters. It treats them as `bathbot_depthcorr.models.wall_fit` treats the default model: residuals in
disparity, where the noise of stereo is the same at all distances (that is, sigma_Z ~ Z^2), Huber's loss at
three sigma, the factory's transform within 0.3 deg and 2 mm, each wall's plane within the covariance that its
chessboard gave.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import cv2
import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.disparity_walls import Wall
from bathbot_depthcorr.models.wall_fit import (
    CORRELATED,
    GROSS,
    LEAST_SIGMA,
    PRIOR_ROTATION,
    PRIOR_TRANSLATION,
    huber_weight,
    moved_transform,
    see_wall,
)
from bathbot_depthcorr.views.views import block_centres
from numpy.typing import NDArray

Array = NDArray[np.float64]

ITERATIONS = 12


class Prediction(NamedTuple):
    """What a model says of the N cells that saw a wall.

    Attributes:
        disparity: Corrected, shape (N,) [px].
        by_shared: Its derivatives by the shared parameters, shape (N, P).
        by_cell: Its derivative by the parameter of its own cell, shape (N,); zero for a model without a map.
    """

    disparity: Array
    by_shared: Array
    by_cell: Array


# of a wall, the shared parameters (P,) and those of the wall's cells (N,)
Model = Callable[[Wall, Array, Array], Prediction]


class JointResult(NamedTuple):
    """Shared parameters (P,), one parameter per cell (rows, columns), and the transform (4, 4)."""

    shared: Array
    cells: Array
    transform: Array


def fit_jointly(
    model: Model, walls: Sequence[Wall], unit: CameraUnit, shared_prior: Array, cell_prior: float
) -> JointResult:
    """Fit a model.

    Args:
        model: Predicts; all its parameters are zero for the identity.
        walls: The views.
        unit: The camera, with the factory's depth -> colour transform.
        shared_prior: Standard deviations of the shared parameters about zero, shape (P,).
        cell_prior: Standard deviation of a cell's parameter about zero.
    """
    return _JointFit(model, walls, unit, np.asarray(shared_prior, dtype=float), cell_prior).run()


class _JointFit:
    """Parameters are: shared (P), motion of the transform (6), the planes (3 each); cells are eliminated."""

    def __init__(
        self,
        model: Model,
        walls: Sequence[Wall],
        unit: CameraUnit,
        shared_prior: Array,
        cell_prior: float,
    ) -> None:
        self.model, self.walls, self.unit = model, walls, unit
        motion = np.repeat([PRIOR_ROTATION, PRIOR_TRANSLATION], 3)
        self.prior, self.cell_prior = np.concatenate([shared_prior, motion]) ** -2.0, cell_prior**-2.0
        self.state = np.zeros(len(self.prior))
        self.cells = np.zeros(np.prod(cell_shape(unit)))
        self.planes = np.stack([wall.plane for wall in walls])

    def run(self) -> JointResult:
        """Iterate; sigma follows the residuals, and beyond `GROSS` sigma they no longer count for it."""
        gate = np.inf
        for _ in range(ITERATIONS):
            rows = [self._rows(wall, plane) for wall, plane in zip(self.walls, self.planes, strict=True)]
            size = np.abs(np.concatenate([row.residual for row in rows]))
            sigma = max(LEAST_SIGMA, 1.4826 * float(np.median(size[size < gate])))
            gate = GROSS * sigma
            self._step(rows, sigma)
        return JointResult(self.state[:-6], self.cells.reshape(cell_shape(self.unit)), self._transform())

    def _transform(self) -> Array:
        return moved_transform(self.unit, self.state[-6:])

    def _rows(self, wall: Wall, plane: Array) -> "_Rows":
        """Residual and derivatives of one wall."""
        predicted = self.model(wall, self.state[:-6], self.cells[wall.blocks])
        seen = see_wall(wall, plane, self._transform(), self.unit.focal_baseline)
        jacobian = np.hstack([predicted.by_shared, -seen.by_motion])
        return _Rows(predicted.disparity - seen.disparity, jacobian, -seen.by_plane, predicted.by_cell)

    def _step(self, rows: list["_Rows"], sigma: float) -> None:
        """One Gauss-Newton step; the cells, each alone in its rows, are eliminated (Schur complement)."""
        count, size = len(self.prior), len(self.prior) + self.planes.size
        hessian = np.zeros((size, size))
        gradient = np.zeros(size)
        hessian[:count, :count], gradient[:count] = np.diag(self.prior), self.prior * self.state
        own, own_gradient = np.full(self.cells.size, self.cell_prior), self.cell_prior * self.cells
        cross = np.zeros((self.cells.size, size))
        for index, (wall, row) in enumerate(zip(self.walls, rows, strict=True)):
            place = np.arange(count + 3 * index, count + 3 * index + 3)
            columns = np.concatenate([np.arange(count), place])
            jacobian = np.hstack([row.jacobian, row.by_plane])
            weight = huber_weight(np.abs(row.residual) / sigma) / (CORRELATED * sigma) ** 2
            weighted = jacobian * weight[:, None]
            hessian[np.ix_(columns, columns)] += weighted.T @ jacobian
            hessian[np.ix_(place, place)] += wall.information
            gradient[columns] += weighted.T @ row.residual
            gradient[place] += wall.information @ (self.planes[index] - wall.plane)
            own[wall.blocks] += weight * row.by_cell**2
            own_gradient[wall.blocks] += weight * row.by_cell * row.residual
            cross[np.ix_(wall.blocks, columns)] += weighted * row.by_cell[:, None]
        solved = cross / own[:, None]
        step = -np.linalg.solve(hessian - cross.T @ solved, gradient - solved.T @ own_gradient)
        self.cells = self.cells - own_gradient / own - solved @ step
        self.state = self.state + step[:count]
        self.planes = self.planes + step[count:].reshape(-1, 3)


class _Rows(NamedTuple):
    """Linearised residuals of one wall, N cells."""

    residual: Array  # (N,) [px]
    jacobian: Array  # by shared parameters and motion, (N, P + 6)
    by_plane: Array  # (N, 3)
    by_cell: Array  # (N,)


def cell_shape(unit: CameraUnit) -> tuple[int, int]:
    """Rows and columns of the cells."""
    u, v = block_centres(unit.depth_camera)
    return len(v), len(u)


def spread_cells(values: NDArray, unit: CameraUnit) -> NDArray[np.float32]:
    """Values at the centres of cells, shape (rows, columns, ...), bilinear at each pixel, (H, W, ...)."""
    size = (unit.depth_camera.width, unit.depth_camera.height)
    resized = cv2.resize(np.asarray(values, dtype=np.float32), size, interpolation=cv2.INTER_LINEAR)
    return np.ascontiguousarray(resized)
