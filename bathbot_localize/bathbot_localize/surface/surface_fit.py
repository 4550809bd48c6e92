"""Robust fit of the surface in a disc around a target's ray, in inverse depth (see `target`)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_localize.errors import LocalizeError

Array = NDArray[np.float64]
_HUBER, _CUT = 1.345, 4.0  # in units of the residuals' robust scale
_ENOUGH_FOR_QUADRIC = 60


class DegenerateSurfaceError(LocalizeError):
    """Points that determine no surface."""

    def __init__(self, count: int, why: str) -> None:
        """Keep the evidence: the number of points."""
        self.count = count
        super().__init__(f"cannot fit a surface to {count} points: {why}; is there depth at the target?")


class SurfaceFit(NamedTuple):
    """A surface near a target's ray, in the camera's frame.

    Attributes:
        direction: The target's ray (x/z, y/z, 1), shape (3,).
        parameters: (w, a, b): inverse depth [1/m] on that ray and its slope, shape (3,).
        covariance: Of the parameters, shape (3, 3).
        scale: Robust standard deviation of the residuals, in depth at the target [m].
        inliers: Share of the points, 0..1, that agree with the surface.
        points: Number of points that agree.
        radius_px: Radius of the disc [px].
    """

    direction: Array
    parameters: Array
    covariance: Array
    scale: float
    inliers: float
    points: int
    radius_px: float

    def point_and_normal(self, parameters: Array | None = None) -> tuple[Array, Array]:
        """Point [m] where the surface meets the ray, and the unit normal there, towards the camera."""
        w, a, b = self.parameters if parameters is None else parameters
        x, y, _ = self.direction
        # A plane n.(x, y, 1) Z = -1 has inverse depth -n.(x, y, 1); n points back at the camera.
        normal = -np.array([a, b, w - a * x - b * y])
        return self.direction / w, normal / np.linalg.norm(normal)


def fit_surface(
    points: ArrayLike, direction: ArrayLike, radius_px: float = 0.0, correlation: float = 1.0
) -> SurfaceFit:
    """Fit a quadric (a plane when points are few) in inverse depth, with Huber's weights.

    Args:
        points: Camera frame [m], shape (..., 3); points with NaN are left out.
        direction: Ray of the target (x/z, y/z, 1), shape (3,).
        radius_px: Of the disc, kept in the result.
        correlation: How many neighbouring points share one piece of noise (4 pi s^2 for noise
            blurred with a Gaussian of s px); scales the covariance, not the surface.

    Raises:
        DegenerateSurfaceError: With fewer than 6 points, or all on one line.
    """
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1) & (points[:, 2] > 0.0)]
    if len(points) < 6:
        raise DegenerateSurfaceError(len(points), "6 are needed")
    inverse_depth = 1.0 / points[:, 2]
    offset = points[:, :2] * inverse_depth[:, None] - np.asarray(direction, dtype=float)[:2]
    size = float(np.abs(offset).max())
    if size <= 0.0:
        raise DegenerateSurfaceError(len(points), "they all lie on one ray")
    x, y = (offset / size).T
    columns = [np.ones_like(x), x, y]
    if len(points) >= _ENOUGH_FOR_QUADRIC:
        columns += [x * x, x * y, y * y]
    design = np.column_stack(columns)
    if np.linalg.matrix_rank(design[:, :3], tol=1e-4 * np.sqrt(len(points))) < 3:
        raise DegenerateSurfaceError(len(points), "they lie on one line")
    solution, weights, scale = _robust(design, inverse_depth)
    agree = np.abs(inverse_depth - design @ solution) <= _CUT * scale
    unit = np.array([1.0, 1.0 / size, 1.0 / size])
    noise = _variance(design, inverse_depth - design @ solution, weights, scale) * max(correlation, 1.0)
    return SurfaceFit(
        np.asarray(direction, dtype=float), solution[:3] * unit, noise[:3, :3] * np.outer(unit, unit),
        scale / solution[0] ** 2, float(agree.mean()), int(agree.sum()), radius_px,
    )  # fmt: skip


def _robust(design: Array, values: Array) -> tuple[Array, Array, float]:
    """Iteratively reweighted least squares: first towards least absolute residuals, then Huber's weights."""
    weights = np.ones(len(values))
    solution = _solve(design, values, weights)
    scale = 0.0
    for step in range(14):
        residual = np.abs(values - design @ solution)
        scale = max(1.4826 * float(np.median(residual)), 1e-9)
        weights = scale / np.maximum(residual, 0.1 * scale) if step < 5 else _huber_with_cut(residual / scale)
        following = _solve(design, values, weights)
        settled = np.abs(following - solution).max() < 1e-3 * scale / np.sqrt(len(values))
        solution = following
        if settled and step > 5:
            break
    return solution, weights, scale


def _huber_with_cut(residual: Array) -> Array:
    """Huber's weights; zero beyond the cut, where a point belongs to another surface."""
    return np.where(residual > _CUT, 0.0, _HUBER / np.maximum(residual, _HUBER))


def _solve(design: Array, values: Array, weights: Array) -> Array:
    scaled = design * weights[:, None]
    normal = scaled.T @ design
    normal[np.diag_indices_from(normal)] *= 1.0 + 1e-12  # keeps an ill-placed disc solvable
    return np.linalg.lstsq(normal, scaled.T @ values, rcond=None)[0]


def _variance(design: Array, residual: Array, weights: Array, scale: float) -> Array:
    """Covariance of a solution with Huber's weights, in the sandwich form.

    The slope of Huber's function is one for small residuals and zero beyond, which is less than its weight.
    """
    slope = np.abs(residual) <= _HUBER * scale
    bread = np.linalg.pinv(design[slope].T @ design[slope])
    meat = (design * np.square(weights * residual)[:, None]).T @ design
    return bread @ meat @ bread * len(residual) / max(len(residual) - design.shape[1], 1)
