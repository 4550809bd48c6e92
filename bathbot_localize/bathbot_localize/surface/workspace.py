"""Where the arm can work: a shell about its shoulder in which its wrist must lie.

With a spherical wrist, reach is a matter of one distance: that of the wrist's centre, a fixed way
behind the target along the outward normal, from the shoulder. A target whose surroundings lie in the
shell can be touched and left again in all directions; one at its edge cannot be scrubbed around.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from bathbot_depthcorr.geometry.rigid import rotate, transform_points
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_SMOOTH = 9  # cells a side over which points are averaged for their normal
_SHARE = 0.8  # of the surroundings that must be workable


@dataclass(frozen=True, slots=True)
class Workspace:
    """A shell about the shoulder, in the base frame.

    Attributes:
        shoulder: Its centre [m].
        nearest: Radius inside which the elbow cannot fold [m].
        farthest: Radius to which the arm stretches with some bend left [m].
        behind: From the target to the wrist's centre, along the outward normal [m].
        within: Radius beyond which no part of the arm comes [m].
    """

    shoulder: tuple[float, float, float]
    nearest: float
    farthest: float
    behind: float
    within: float

    def holds(self, points_base: Array, outward: Array) -> Mask:
        """Whether skin at points [m] with outward unit normals, both (..., 3), can be worked on, (...)."""
        wrist = points_base + self.behind * outward
        distance = np.linalg.norm(wrist - np.asarray(self.shoulder), axis=-1)
        with np.errstate(invalid="ignore"):
            return (distance >= self.nearest) & (distance <= self.farthest)

    def workable(self, points: Array, normals: Array, T_base_colour: Array, around: int) -> Mask:
        """Cells of a surface whose surroundings the arm can work on.

        Args:
            points: Organised points in the colour camera's frame [m], shape (H, W, 3), NaN where unknown.
            normals: Outward unit normals there, likewise.
            T_base_colour: Pose of the colour camera in the base frame, shape (4, 4).
            around: Side of the surroundings [cells].

        Returns:
            Mask, shape (H, W); false where unknown.
        """
        known = np.isfinite(points[..., 2])
        within = known & self.holds(transform_points(T_base_colour, points), rotate(T_base_colour, normals))
        seen = cv2.blur(known.astype(np.float32), (around, around))
        share = cv2.blur(within.astype(np.float32), (around, around)) / np.maximum(seen, 1e-6)
        return within & (share >= _SHARE)


def outward_normals(points: Array) -> Array:
    """Unit normals towards the camera, shape (H, W, 3), of averaged points; NaN where they have none.

    Args:
        points: Organised points in the camera's frame [m], shape (H, W, 3), NaN where unknown.
    """
    known = np.isfinite(points[..., 2])
    if min(known.shape) < 2:
        return np.full(points.shape, np.nan)
    weight = cv2.blur(known.astype(np.float64), (_SMOOTH, _SMOOTH))
    mean = cv2.blur(np.where(known[..., None], points, 0.0), (_SMOOTH, _SMOOTH))
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = mean / np.where(weight > 0.0, weight, np.nan)[..., None]
        normals = np.cross(np.gradient(mean, axis=1), np.gradient(mean, axis=0))
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        return np.where(np.sum(normals * mean, axis=-1, keepdims=True) > 0.0, -normals, normals)
