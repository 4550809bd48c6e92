"""The border where poses become transforms.

Works on any object with the fields of geometry_msgs/Pose and geometry_msgs/Transform, so live messages and
those read from a bag without ROS go through the same door.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.rigid import rotation_from_quaternion

Array = NDArray[np.float64]


def pose_values(poses: Sequence[Any]) -> Array:
    """Positions [m] and quaternions (x, y, z, w) of geometry_msgs/Pose as they stand there, shape (N, 7)."""
    return _values([(pose.position, pose.orientation) for pose in poses])


def transforms_from_poses(poses: Sequence[Any]) -> Array:
    """Transforms, shape (N, 4, 4), of geometry_msgs/Pose: map the posed body to the frame it is given in."""
    return _transforms(pose_values(poses))


def transform_from_pose(pose: Any) -> Array:
    """Transform, shape (4, 4), of one geometry_msgs/Pose."""
    return transforms_from_poses([pose])[0]


def transform_from_message(message: Any) -> Array:
    """Transform, shape (4, 4), of a geometry_msgs/Transform."""
    return _transforms(_values([(message.translation, message.rotation)]))[0]


def _values(pairs: list[tuple[Any, Any]]) -> Array:
    """Translations and quaternions side by side, shape (N, 7)."""
    return np.array([(t.x, t.y, t.z, q.x, q.y, q.z, q.w) for t, q in pairs], dtype=float).reshape(-1, 7)


def _transforms(values: Array) -> Array:
    transforms = np.tile(np.eye(4), (len(values), 1, 1))
    if len(values):
        transforms[:, :3, :3] = rotation_from_quaternion(values[:, 3:])
        transforms[:, :3, 3] = values[:, :3]
    return transforms
