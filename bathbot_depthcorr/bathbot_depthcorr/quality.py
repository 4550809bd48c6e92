"""How good depth is: Eqs. (3) and (4), fill rate and the tail of the errors.

Eq. (3) differs from the paper's prose: the text says "average depth minus truth", the formula is a mean
of absolute errors. Both are given here, `signed` and `absolute`.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_depthcorr.errors import DepthcorrError
from bathbot_depthcorr.plane import Plane, fit_plane

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


def fill_rate(depth: ArrayLike) -> float:
    """Share of pixels, 0..1, that have depth."""
    return float(np.isfinite(np.asarray(depth)).mean())
