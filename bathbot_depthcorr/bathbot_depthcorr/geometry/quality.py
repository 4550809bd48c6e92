"""How good depth is: Eqs. (3) and (4), fill rate and the tail of the errors.

Eq. (3) differs from the paper's prose: the text says "average depth minus truth", the formula is a mean
of absolute errors. Both are given here, `signed` and `absolute`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_depthcorr.errors import DepthcorrError
from bathbot_depthcorr.geometry.plane import Plane, fit_plane

Array = NDArray[np.float64]


class NoDepthError(DepthcorrError):
    """An image without one usable depth."""

    def __init__(self) -> None:
        super().__init__(
            "no pixel has both depth and truth (fill rate 0); is the wall within the camera's range?"
        )


class ZAccuracy(NamedTuple):
    """Eq. (3): mean error, mean absolute error and the 95th percentile of the absolute error, all [m]."""

    signed: float
    absolute: float
    percentile_95: float


def z_accuracy(depth: ArrayLike, truth: ArrayLike) -> ZAccuracy:
    """Compare depth [m], shape (...), with the true depth [m], a number or shape (...), by Eq. (3).

    Raises:
        NoDepthError: If no pixel has both.
    """
    error = np.asarray(depth, dtype=float) - np.asarray(truth, dtype=float)
    error = error[np.isfinite(error)]
    if error.size == 0:
        raise NoDepthError
    size = np.abs(error)
    return ZAccuracy(float(error.mean()), float(size.mean()), float(np.percentile(size, 95.0)))


def plane_rmse(points: ArrayLike, plane: Plane | None = None) -> float:
    """Root mean square distance [m] of points, shape (..., 3), from a plane, Eq. (4).

    Args:
        points: In any frame [m]; those with NaN are left out.
        plane: In the same frame; the best fit to the points by default.

    Raises:
        DegeneratePlaneError: If no plane was given and the points determine none.
    """
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    distance = (plane or fit_plane(points)).distance(points)
    return float(np.sqrt(np.mean(np.square(distance))))


def wall_accuracy(points: ArrayLike, plane: Plane, distance: float) -> float:
    """Z-accuracy as Intel's depth quality tool gives it: median signed error over the true distance.

        median_i(z(plane) - distance + e_i) / distance

    z(plane) is the depth of the fitted plane on the optical axis, e_i the distance of point i behind the
    plane. Positive means that the wall is seen too far.

    Args:
        points: Of a wall, in the camera frame [m], shape (..., 3); those with NaN are left out.
        plane: Fitted to them, facing the camera.
        distance: True depth of the wall on the optical axis [m]; the wall should be seen at a right angle.
    """
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    behind = -plane.distance(points[np.isfinite(points).all(axis=1)])
    seen = float(plane.depth_along((0.0, 0.0, 1.0)))
    return float(np.median(seen - distance + behind)) / distance


def temporal_noise(depth: ArrayLike, before: ArrayLike) -> float:
    """Standard deviation between frames [m], robust, from two frames of a still scene, shape (...).

    NaN if no pixel has depth in both.
    """
    change = np.asarray(depth, dtype=float) - np.asarray(before, dtype=float)
    change = np.abs(change[np.isfinite(change)])
    return 1.4826 * float(np.median(change)) / np.sqrt(2.0) if change.size else float("nan")


def fill_rate(depth: ArrayLike) -> float:
    """Share of pixels, 0..1, that have depth."""
    return float(np.isfinite(np.asarray(depth)).mean())
