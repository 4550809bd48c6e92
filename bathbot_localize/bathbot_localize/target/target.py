"""Contact targets: position and pose of a target point, Eq. (5) and Fig. 5, and their error, Eq. (19).

The paper draws a disc around the target pixel, lifts its pixels by Eq. (5) and takes the normal of
the surface they define. The surface here is a quadric in inverse depth: with x, y the ray
coordinates relative to the target's ray,

    1/Z = w + a x + b y + (c x^2 + d x y + e y^2)

A plane is exactly linear in this form, so (w, a, b) give position and normal without iteration. The
noise of a stereo camera is uniform in inverse depth: equal weights here are the weights
1 / sigma_Z^2 of a fit in depth. The position is the fitted surface on the ray of the target pixel,
never one noisy pixel. The target's frame is that of the scrub head: z into the skin (minus the
outward normal), y along the skin, x = y cross z.
"""

from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.rigid import rotate, transform_points
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from bathbot_localize.surface.surface_fit import SurfaceFit

Array = NDArray[np.float64]
_STEEP = 0.9  # beyond this |cosine| between normal and base z, y follows base x instead


class Target(NamedTuple):
    """Where the scrub head shall touch a region.

    Attributes:
        T_base_target: Maps the target's frame to the base frame, shape (4, 4).
        covariance: Of position [m^2] and rotation about fixed axes [rad^2] in the base frame, (6, 6).
        pixel: Target (u, v) [px] in the colour picture.
        radius_px: Radius of the disc whose points were used [px].
        points: Number of points in that disc that agree with the surface.
    """

    region: str
    score: float
    T_base_target: Array
    covariance: Array
    pixel: tuple[float, float]
    radius_px: float
    points: int


def pose_from_normal(position: ArrayLike, normal: ArrayLike) -> Array:
    """Pose of the scrub head on a surface, shape (4, 4), in the frame of its arguments (the base).

    z = -normal; y is base z projected onto the surface, so that the head travels up and down a
    standing surface, or base x where the surface lies flat. The rotation is right-handed.

    Args:
        position: Point on the skin [m], shape (3,).
        normal: Outward unit normal, shape (3,).
    """
    normal = np.asarray(normal, dtype=float)
    guide = np.array([1.0, 0.0, 0.0]) if abs(normal[2]) > _STEEP else np.array([0.0, 0.0, 1.0])
    along = guide - (guide @ normal) * normal
    along /= np.linalg.norm(along)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([np.cross(along, -normal), along, -normal])
    pose[:3, 3] = position
    return pose


def target_from_fit(
    region: str, score: float, fit: SurfaceFit, T_base_colour: ArrayLike, pixel: tuple[float, float],
    systematic: float = 0.0,
) -> Target:  # fmt: skip
    """The contact target of a fitted disc.

    Args:
        region: Class name.
        score: Confidence of the detection, 0..1.
        fit: Surface around the target's ray, in the colour camera's frame.
        T_base_colour: Maps colour camera coordinates to the base, shape (4, 4).
        pixel: Target (u, v) [px].
        systematic: Standard deviation [m] of what does not average out: rest of the depth
            correction and of hand-eye; added to the position on every axis.
    """
    T_base_colour = np.asarray(T_base_colour, dtype=float)

    def pose_of(parameters: Array) -> Array:
        position, normal = fit.point_and_normal(parameters)
        return pose_from_normal(transform_points(T_base_colour, position), rotate(T_base_colour, normal))

    pose = pose_of(fit.parameters)
    jacobian = np.empty((6, 3))
    for column, step in enumerate(np.sqrt(np.diag(fit.covariance)) * 1e-3 + 1e-9):
        moved = fit.parameters.copy()
        moved[column] += step
        other = pose_of(moved)
        jacobian[:3, column] = (other[:3, 3] - pose[:3, 3]) / step
        jacobian[3:, column] = Rotation.from_matrix(other[:3, :3] @ pose[:3, :3].T).as_rotvec() / step
    covariance = jacobian @ fit.covariance @ jacobian.T
    covariance[:3, :3] += np.eye(3) * systematic**2
    return Target(region, score, pose, (covariance + covariance.T) / 2.0, pixel, fit.radius_px, fit.points)


def localization_error(theoretical: ArrayLike, actual: ArrayLike) -> Array:
    """Distance [m] between theoretical and actual positions, shape (..., 3) -> (...), Eq. (19)."""
    return np.linalg.norm(np.asarray(theoretical, dtype=float) - np.asarray(actual, dtype=float), axis=-1)


def axis_errors(theoretical: ArrayLike, actual: ArrayLike) -> Array:
    """Absolute differences [m] along each axis, shape (..., 3), as in Table 2."""
    return np.abs(np.asarray(theoretical, dtype=float) - np.asarray(actual, dtype=float))
