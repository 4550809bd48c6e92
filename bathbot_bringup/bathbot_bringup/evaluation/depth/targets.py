"""What the cameras of the evaluation look at: walls near and far, walls at the working distance, limbs."""

from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.plane import Plane
from bathbot_depthcorr.geometry.rigid import rotate, transform_points
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from bathbot_bringup.evaluation.depth.simulated_unit import Surface

Array = NDArray[np.float64]

DISTANCES = (0.5, 0.6, 0.7, 0.8, 0.9, 1.1, 1.4, 2.0)  # [m]
WORKING = (0.62, 0.88)  # [m], the distances of the paper's Table 2
WALLS = 3  # per distance
WORKING_WALLS = 8
TILT = np.deg2rad(20.0)
RADII = (0.04, 0.16)  # [m]: a forearm, a trunk
CURVED_DISTANCE = 0.7  # [m]


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


class Target(NamedTuple):
    """Something to look at.

    Attributes:
        kind: "wall", "working" (a wall at a working distance) or "cylinder".
        distance: Along the axis of the colour camera [m].
        surface: In the colour frame.
        radius: Of a cylinder [m], else 0.
    """

    kind: str
    distance: float
    surface: Surface
    radius: float = 0.0


def wall(distance: float, tilt_x: float = 0.0, tilt_y: float = 0.0) -> Plane:
    """A wall in the colour frame: distance along the axis [m], tilts about x and y [rad]."""
    normal = Rotation.from_euler("xy", (tilt_x, tilt_y)).apply((0.0, 0.0, -1.0))
    return Plane(normal, float(normal[2] * distance))


def targets(seed: int) -> list[Target]:
    """All targets of one unit: of each kind the first is seen frontally, the others are tilted at random."""
    rng = np.random.default_rng([seed, 93])

    def tilts(number: int) -> np.ndarray:
        return rng.uniform(-TILT, TILT, 2) if number else np.zeros(2)

    found = [Target("wall", z, wall(z, *tilts(k))) for z in DISTANCES for k in range(WALLS)]
    near = rng.uniform(*WORKING, WORKING_WALLS)
    found += [Target("working", z, wall(z, *tilts(k))) for k, z in enumerate(near.tolist())]
    for radius in RADII:
        direction = np.deg2rad(rng.uniform(0.0, 180.0))
        axis = np.array([np.cos(direction), np.sin(direction), rng.uniform(-0.2, 0.2)])
        axis /= np.linalg.norm(axis)
        point = np.array([0.0, 0.0, CURVED_DISTANCE + radius])
        found.append(Target("cylinder", CURVED_DISTANCE, Cylinder(point, axis, radius), radius))
    return found
