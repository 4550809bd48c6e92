"""Basso, Menegatti and Pretto 2018: a local map that flattens, then a global one with the transform.

    z' = a_0 + a_1 z + a_2 z^2 per cell (bilinear in between),    Z' = p_1(u, v) z' + p_2(u, v) z'^2

Local map, views from near to far: the cloud corrected so far says which points are wall; the plane is
fitted to the *raw* ones of these inside the circle about the image's middle, and each inlier's cell learns
the depth at which its ray meets that plane. A second pass begins anew with the inliers of both. Global map:
p_1 and p_2 are bilinear between the corners, three of them free (so they are linear over the image), and
without a constant term; they are fitted together with the transform and the walls' planes.

What is chosen here, as it is not published or was made for another sensor:

* Cells are 8 px wide at 848 columns, samples are their means; they weigh 1 / Z^4, as stereo noise demands.
* A cell learns from its first sample on, held by a weak prior whose size served best on simulated units;
  published: from ten samples on, none before, which few poses do not reach.
* Huber's loss in the joint fit; published: none. Priors: p_1 within 5 %, p_2 within 0.1 / m.
* The published focal length and centre of the depth camera are not refined, as in no method here.

At distances never seen both polynomials continue.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.plane import fit_plane
from bathbot_depthcorr.models.disparity_walls import Wall, wall_rows
from bathbot_depthcorr.views.views import CalibrationView, nearest_first
from numpy.typing import NDArray

from bathbot_bringup.evaluation.depth.measures import Depth, positive
from bathbot_bringup.evaluation.depth.methods.joint_fit import (
    Prediction,
    cell_shape,
    fit_jointly,
    spread_cells,
)

Array = NDArray[np.float64]

CELL_NOISE = 0.06  # [px] of disparity, mean of a cell
PRIOR_LOCAL = np.array([0.005, 0.015, 0.015])  # standard deviations of a_0 [m], a_1 - 1, a_2 [1/m]
IDENTITY = np.array([0.0, 1.0, 0.0])
PRIOR_GLOBAL = np.repeat([0.05, 0.1], 3)  # standard deviations of p_1 - 1 and of p_2 [1/m]
INLIER = 6.0  # standard deviations from the corrected wall
LEAST_SPREAD = 5e-4  # [m], so that exact data keep their points


@dataclass(frozen=True, slots=True, eq=False)
class Basso:
    """The local map as coefficients of z, lowest first, (H, W, 3); p_1 and p_2 of the global one, (H, W)."""

    T_colour_depth: Array
    local: Depth
    linear: Depth
    square: Depth

    def apply(self, depth: Depth) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        flat = self.local[..., 0] + depth * (self.local[..., 1] + depth * self.local[..., 2])
        return positive(np.where(flat > 0.0, flat * (self.linear + flat * self.square), np.nan))


def fit_basso(views: Sequence[CalibrationView], unit: CameraUnit) -> Basso:
    """Fit the local map from near to far, then the global one and the transform."""
    walls = [wall_rows(view, unit) for view in nearest_first(views)]
    local = _fit_local(walls, unit)
    flat = [wall._replace(disparity=unit.focal_baseline / local.apply(wall)) for wall in walls]

    def model(wall: Wall, shared: Array, cells: Array) -> Prediction:
        depth = unit.focal_baseline / wall.disparity
        across = _affine(wall.pixels, unit)
        powers = np.hstack([across * depth[:, None], across * depth[:, None] ** 2])
        corrected = depth + powers @ shared
        slope = -unit.focal_baseline / corrected**2
        return Prediction(unit.focal_baseline / corrected, powers * slope[:, None], np.zeros_like(cells))

    fitted = fit_jointly(model, flat, unit, PRIOR_GLOBAL, 1.0)
    across = _affine(unit.depth_camera.pixel_grid(), unit)
    return Basso(
        fitted.transform,
        spread_cells(local.coefficients.reshape(*cell_shape(unit), 3), unit),
        (1.0 + across @ fitted.shared[:3]).astype(np.float32),
        (across @ fitted.shared[3:]).astype(np.float32),
    )


def _affine(pixels: Array, unit: CameraUnit) -> Array:
    """1, x and y of pixels (u, v), shape (..., 2) -> (..., 3); x and y run from -1 to 1 over the image."""
    size = np.array([unit.depth_camera.width, unit.depth_camera.height])
    x, y = np.moveaxis((pixels + 0.5) * 2.0 / size - 1.0, -1, 0)
    return np.stack([np.ones_like(x), x, y], axis=-1)


def _fit_local(walls: Sequence[Wall], unit: CameraUnit) -> "_LocalMap":
    """Learn from walls, near to far, and again from the inliers of both passes."""
    first, second, inliers = _LocalMap(unit), _LocalMap(unit), []
    for wall in walls:
        inliers.append(first.inliers(wall))
        first.learn(wall, inliers[-1])
    for wall, mask in zip(walls, inliers, strict=True):
        second.learn(wall, mask | first.inliers(wall))
    return second


class _LocalMap:
    """A quadratic per cell, and the normal equations of all it has learnt.

    Attributes:
        coefficients: Lowest first, shape (cells, 3).
    """

    def __init__(self, unit: CameraUnit) -> None:
        self.unit, count = unit, int(np.prod(cell_shape(unit)))
        self.coefficients = np.tile(IDENTITY, (count, 1))
        self._normal = np.tile(np.diag(PRIOR_LOCAL**-2.0), (count, 1, 1))
        self._right = self._normal @ IDENTITY

    def apply(self, wall: Wall) -> Array:
        """Corrected depth [m] of a wall's N cells, shape (N,)."""
        depth = self.unit.focal_baseline / wall.disparity
        return np.sum(self.coefficients[wall.blocks] * depth[:, None] ** np.arange(3), axis=1)

    def inliers(self, wall: Wall) -> NDArray[np.bool_]:
        """Which of a wall's N cells lie, corrected, on the corrected wall, shape (N,)."""
        points = wall.directions * self.apply(wall)[:, None]
        away = np.abs(fit_plane(points, robust=True).distance(points))
        return away < INLIER * max(LEAST_SPREAD, 1.4826 * float(np.median(away)))

    def learn(self, wall: Wall, inliers: NDArray[np.bool_]) -> None:
        """Add a sample to each inlier's cell: where its ray meets the plane of the raw cloud's middle."""
        depth, camera = self.unit.focal_baseline / wall.disparity, self.unit.depth_camera
        weight = (self.unit.focal_baseline / (CELL_NOISE * depth**2)) ** 2
        middle = 0.5 * np.array([camera.width - 1, camera.height - 1])
        circle = np.linalg.norm(wall.pixels - middle, axis=1) < 0.5 * camera.height
        plane = fit_plane(wall.directions * depth[:, None], np.where(circle & inliers, weight, 0.0))
        target = plane.depth_along(wall.directions)
        used = inliers & np.isfinite(target)
        powers = depth[used, None] ** np.arange(3)
        weighted = weight[used, None] * powers
        self._normal[wall.blocks[used]] += weighted[:, :, None] * powers[:, None, :]
        self._right[wall.blocks[used]] += weighted * target[used, None]
        self.coefficients = np.linalg.solve(self._normal, self._right[:, :, None])[:, :, 0]
