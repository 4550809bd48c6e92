"""Rigid transforms as 4x4 matrices.

`T_base_camera` maps camera coordinates to base coordinates, so transforms chain by eye:
`T_base_camera @ T_camera_tag`. Quaternions are (x, y, z, w) with w >= 0, as in ROS messages.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def transform_from(rotation: ArrayLike | None = None, translation: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Build a transform, shape (4, 4), from a rotation matrix (3, 3) and a translation [m], (3,)."""
    transform = np.eye(4)
    if rotation is not None:
        transform[:3, :3] = rotation
    transform[:3, 3] = translation
    return transform


def inverse(transform: ArrayLike) -> Array:
    """Invert rigid transforms, shape (..., 4, 4), without a linear solve."""
    transform = np.asarray(transform, dtype=float)
    rotation = np.swapaxes(transform[..., :3, :3], -1, -2)
    result = np.zeros_like(transform)
    result[..., :3, :3] = rotation
    result[..., :3, 3] = -np.einsum("...ij,...j->...i", rotation, transform[..., :3, 3])
    result[..., 3, 3] = 1.0
    return result


def rotate(transform: ArrayLike, vectors: ArrayLike) -> Array:
    """Rotate vectors, shape (..., 3), by one transform; the translation does not act."""
    return np.asarray(vectors) @ np.asarray(transform)[:3, :3].T


def transform_points(transform: ArrayLike, points: ArrayLike) -> Array:
    """Map points [m], shape (..., 3), by one transform, shape (4, 4)."""
    return rotate(transform, points) + np.asarray(transform)[:3, 3]


def rotation_from_quaternion(quaternion: ArrayLike) -> Array:
    """Rotation matrices, shape (..., 3, 3), of quaternions (x, y, z, w), shape (..., 4)."""
    return Rotation.from_quat(np.asarray(quaternion, dtype=float)).as_matrix()


def quaternion_from_rotation(rotation: ArrayLike) -> Array:
    """Unit quaternions (x, y, z, w), w >= 0, shape (..., 4), of rotation matrices (..., 3, 3)."""
    return Rotation.from_matrix(np.asarray(rotation, dtype=float)).as_quat(canonical=True)


def rotation_angle(rotation: ArrayLike) -> Array:
    """Angles [rad], 0..pi, by which rotation matrices, shape (..., 3, 3), turn."""
    return Rotation.from_matrix(np.asarray(rotation, dtype=float)).magnitude()
