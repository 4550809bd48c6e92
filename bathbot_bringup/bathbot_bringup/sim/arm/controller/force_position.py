"""Hybrid force and position control of the emulated arm: axes of the tool or base that yield to a force.

How firmware does it is not published. Here each axis that is controlled moves with a speed in proportion
to the force that is missing, turning axes stay fixed, and the rest of the motion is untouched.
"""

from dataclasses import dataclass

import numpy as np
from bathbot_scrub.rm65.arm.rm65 import RM65
from numpy.typing import NDArray

Array = NDArray[np.float64]
_GAIN = 0.004  # [m/s/N]
_FLOAT, _TRACK = 1, (4, 8)  # control modes: yield to any force, hold the desired one


@dataclass(frozen=True, slots=True)
class ForcePosition:
    """What is to be held."""

    in_tool: bool  # axes of the tool, else of the base
    modes: tuple[int, ...]  # per axis
    force: Array  # [N] with which the tool shall press along x, y, z, shape (3,)
    limit: Array  # [m/s] along x, y, z, shape (3,)

    def joint_speed(self, kinematics: RM65, joints: Array, wrench: Array) -> Array:
        """Speed of the joints [rad/s], shape (6,), that takes the force nearer to the desired one.

        Args:
            kinematics: The arm.
            joints: [rad], shape (6,).
            wrench: External force as the sensor tells it [N], sensor frame, shape (6,).
        """
        R_base_flange = kinematics.flange(joints)[:3, :3]
        axes = R_base_flange if self.in_tool else np.eye(3)
        felt = axes.T @ R_base_flange @ np.nan_to_num(wrench[:3])
        modes = np.array(self.modes[:3])
        desired = np.where(modes == _FLOAT, 0.0, self.force)
        held = np.isin(modes, (_FLOAT, *_TRACK))
        speed = np.where(held, np.clip(_GAIN * (desired + felt), -self.limit, self.limit), 0.0)
        twist = np.concatenate([axes @ speed, np.zeros(3)])
        return np.linalg.pinv(kinematics.jacobian(joints), rcond=0.02) @ twist
