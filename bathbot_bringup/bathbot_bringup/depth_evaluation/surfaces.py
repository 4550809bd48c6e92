"""Curved test surfaces; walls are `bathbot_depthcorr.plane.Plane`, which answers the same two questions."""

from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.rigid import rotate, transform_points
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Cylinder(NamedTuple):
    """An endless cylinder: a point on its axis [m], shape (3,), the unit axis, shape (3,), a radius [m]."""

    point: Array
    axis: Array
    radius: float

    def depth_along(self, directions: ArrayLike) -> Array:
        """Depth [m] at which rays (x/z, y/z, 1), shape (..., 3), first meet the surface; NaN if never."""
        directions = np.asarray(directions, dtype=float)
        ray = directions - (directions @ self.axis)[..., None] * self.axis
        point = self.point - (self.point @ self.axis) * self.axis
        square, mixed = np.sum(ray * ray, axis=-1), ray @ point
        inside = mixed**2 - square * (point @ point - self.radius**2)
        with np.errstate(invalid="ignore"):
            depth = (mixed - np.sqrt(inside)) / square
        return np.where(depth > 0.0, depth, np.nan)

    def transformed(self, transform: ArrayLike) -> "Cylinder":
        """The same cylinder in another frame: `T_base_camera` takes a camera cylinder to the base."""
        return Cylinder(transform_points(transform, self.point), rotate(transform, self.axis), self.radius)
