"""Planes: the walls of the calibration and the tangent planes of the skin."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_depthcorr.errors import DepthcorrError

Array = NDArray[np.float64]


class DegeneratePlaneError(DepthcorrError):
    """Points that do not determine a plane."""

    def __init__(self, count: int, spread: float) -> None:
        """Keep the evidence: the number of points and their second spread [m]."""
        self.count, self.spread = count, spread
        super().__init__(
            f"cannot fit a plane to {count} points with second spread {spread:.2e} m; "
            "is the surface inside the depth image?"
        )


class Plane(NamedTuple):
    """Plane n.x = d, with unit normal n, shape (3,), and offset d [m].

    Fitted planes face the origin (d <= 0), as a surface faces the camera that sees it.
    """

    normal: Array
    offset: float

    def distance(self, points: ArrayLike) -> Array:
        """Signed distance n.x - d [m] of points, shape (..., 3); positive on the normal's side."""
        return np.asarray(points) @ self.normal - self.offset

    def depth_along(self, directions: ArrayLike) -> Array:
        """Depth [m] at which rays (x/z, y/z, 1), shape (..., 3), meet the plane; NaN if they do not."""
        slope = np.asarray(directions) @ self.normal
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = self.offset / slope
        return np.where(np.isfinite(depth) & (depth > 0.0), depth, np.nan)

    def transformed(self, transform: ArrayLike) -> "Plane":
        """The same plane in another frame: `T_base_camera` takes a camera plane to the base."""
        transform = np.asarray(transform)
        normal = transform[:3, :3] @ self.normal
        return Plane(normal, float(self.offset + normal @ transform[:3, 3]))

    @property
    def inverse_form(self) -> Array:
        """Vector m with m.x = 1 on the plane [1/m], shape (3,)."""
        return self.normal / self.offset


def plane_from_inverse_form(inverse_form: ArrayLike) -> Plane:
    """The plane m.x = 1 of a vector m [1/m], shape (3,), facing the origin."""
    m = np.asarray(inverse_form, dtype=float)
    length = float(np.linalg.norm(m))
    return Plane(-m / length, -1.0 / length)


def fit_plane(points: ArrayLike, weights: ArrayLike | None = None, robust: bool = False) -> Plane:
    """Fit a plane by weighted least squares of the orthogonal distance.

    Args:
        points: Shape (..., 3) [m]; points with NaN are left out.
        weights: Shape (...), usually 1 / variance; all equal by default.
        robust: Reweight with Tukey's function, so that a few flying pixels do no harm.

    Raises:
        DegeneratePlaneError: With fewer than three points, or points on one line.
    """
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    weights = np.ones(len(points)) if weights is None else np.asarray(weights, dtype=float).reshape(-1)
    usable = np.isfinite(points).all(axis=1) & (weights > 0.0)
    points, weights = points[usable], weights[usable]
    plane = _least_squares(points, weights)
    for _ in range(10 if robust else 0):
        distance = plane.distance(points)
        scale = 1.4826 * float(np.median(np.abs(distance)))
        if scale < 1e-9:
            break
        following = _least_squares(points, weights * _tukey(distance / scale))
        settled = abs(following.offset - plane.offset) < 1e-8
        plane = following
        if settled:
            break
    return plane


def _tukey(residual: Array) -> Array:
    """Tukey's biweight of residuals in units of their scale: zero beyond 4.685."""
    return np.square(np.clip(1.0 - np.square(residual / 4.685), 0.0, None))


def _least_squares(points: Array, weights: Array) -> Plane:
    if np.count_nonzero(weights) < 3:
        raise DegeneratePlaneError(int(np.count_nonzero(weights)), 0.0)
    total = weights.sum()
    centre = weights @ points / total
    shifted = points - centre
    variances, axes = np.linalg.eigh((shifted * weights[:, None]).T @ shifted / total)
    spread = float(np.sqrt(max(variances[1], 0.0)))
    if spread < 1e-6 or variances[1] < 1e-10 * variances[2]:
        raise DegeneratePlaneError(len(points), spread)
    normal = axes[:, 0]
    offset = float(normal @ centre)
    return Plane(-normal, -offset) if offset > 0.0 else Plane(normal, offset)
