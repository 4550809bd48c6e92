"""Arm poses that show a plate on the flange to the camera, for hand-eye calibration."""

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.installed_arm import installed_arm
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from bathbot_bringup.errors import BringupError

Array = NDArray[np.float64]
DISTANCE = (0.40, 0.60)  # [m] of the flange from the camera
SPREAD = 0.08  # [m] of the flange beside the axis, standard deviation
TILT = (0.35, 0.75)  # [rad] of the flange against the line of sight
ROLL = 1.2  # [rad] about it, largest
_MOST_TRIALS = 20000


def marker_poses(T_base_camera: ArrayLike, home: ArrayLike, count: int, seed: int) -> Array:
    """Choose joint angles, each near the last, with the flange turned towards the camera.

    Args:
        T_base_camera: Roughly where the camera is, optical frame, shape (4, 4).
        home: Joint angles at the start [rad], shape (6,).
        count: How many.
        seed: Of the choice.

    Returns:
        Joint angles [rad], shape (count, 6).

    Raises:
        BringupError: When the arm cannot show itself to such a camera.
    """
    random, arm = np.random.default_rng(seed), installed_arm()
    T_base_camera, joints = np.asarray(T_base_camera, dtype=float), np.asarray(home, dtype=float)
    found: list[Array] = []
    for _ in range(_MOST_TRIALS):
        if len(found) == count:
            return np.array(found)
        flange = T_base_camera @ _flange_before_camera(random)
        solutions = arm.solve_head(flange @ arm.tool.T_flange_head)
        if np.isfinite(solutions).all(axis=-1).any():
            joints = nearest(solutions, joints, arm.limits)
            found.append(joints)
    raise BringupError(
        f"only {len(found)} of {count} arm poses show the marker to a camera at "
        f"{T_base_camera[:3, 3].round(2)} m; is it in front of the arm?"
    )


def _flange_before_camera(random: np.random.Generator) -> Array:
    """A random pose of the flange in the camera's frame, its z towards the camera."""
    tilt = Rotation.from_rotvec(random.uniform(*TILT) * _across(random))
    turn = Rotation.from_euler("xz", [np.pi, random.uniform(-ROLL, ROLL)])
    position = [*random.normal(0.0, SPREAD, 2), random.uniform(*DISTANCE)]
    return transform_from((tilt * turn).as_matrix(), position)


def _across(random: np.random.Generator) -> Array:
    angle = random.uniform(0.0, 2.0 * np.pi)
    return np.array([np.cos(angle), np.sin(angle), 0.0])
