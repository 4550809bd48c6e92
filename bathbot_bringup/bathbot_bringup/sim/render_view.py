"""Where a camera stands."""

import numpy as np
from bathbot_depthcorr.rigid import transform_from
from numpy.typing import ArrayLike, NDArray


def looking_at(eye: ArrayLike, target: ArrayLike, roll: float = 0.0) -> NDArray[np.float64]:
    """Pose of a camera's optical frame (z forward, x right, y down) in a world with z up.

    Args:
        eye: Where the camera is [m], shape (3,).
        target: What it looks at [m], shape (3,).
        roll: Turn about the optical axis [rad].

    Returns:
        T_world_camera, shape (4, 4).
    """
    eye, target = np.asarray(eye, dtype=float), np.asarray(target, dtype=float)
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross(z, (0.0, 0.0, 1.0))
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    c, s = np.cos(roll), np.sin(roll)
    return transform_from(np.stack([c * x + s * y, c * y - s * x, z], axis=-1), eye)
