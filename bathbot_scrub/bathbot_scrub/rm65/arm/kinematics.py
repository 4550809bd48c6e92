"""Forward kinematics of the RM65 from its published modified Denavit-Hartenberg table.

Craig's convention, T(i-1, i) = Rx(alpha(i-1)) Tx(a(i-1)) Rz(q(i) + offset(i)) Tz(d(i)). The variants differ
in d6, the distance from the wrist centre to the flange: 6F carries the force sensor as an extra part,
6FB has it built in.
"""

from dataclasses import dataclass
from math import cos, sin

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD, ScrubHead
from numba import njit
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.errors import ArmSettingsError

Array = NDArray[np.float64]

FLANGE_OFFSETS = {"B": 0.144, "6F": 0.1725, "6FB": 0.1612}  # d6 [m]
BASE_HEIGHT = 0.2405  # d1 [m]: base to shoulder
UPPER_ARM = 0.256  # a2 [m]: shoulder to elbow
FOREARM = 0.210  # d4 [m]: elbow to wrist centre
LINK_NAMES = ("base_link", "Link1", "Link2", "Link3", "Link4", "Link5", "Link6")
JOINT_NAMES = ("joint1", "joint2", "joint3", "joint4", "joint5", "joint6")

_QUARTER = np.pi / 2
_COS_ALPHA = (1.0, 0.0, 1.0, 0.0, 0.0, 0.0)  # alpha is 0, 90, 0, 90, -90, 90 deg
_SIN_ALPHA = (0.0, 1.0, 0.0, 1.0, -1.0, 1.0)
_A = (0.0, 0.0, UPPER_ARM, 0.0, 0.0, 0.0)
_THETA = (0.0, _QUARTER, _QUARTER, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Kinematics:
    """Where links, flange and scrub head are, for joint angles [rad]; frames are in base_link."""

    variant: str = "6F"
    tool: ScrubHead = SCRUB_HEAD

    def __post_init__(self) -> None:
        """Refuse an unknown variant."""
        if self.variant not in FLANGE_OFFSETS:
            raise ArmSettingsError(
                f"unknown RM65 variant {self.variant!r}; known are {', '.join(FLANGE_OFFSETS)}"
            )

    @property
    def flange_offset(self) -> float:
        """Distance d6 from the wrist centre to the flange [m]."""
        return FLANGE_OFFSETS[self.variant]

    def link_frames(self, joints: ArrayLike) -> Array:
        """Transforms T_base_link of base_link and Link1..Link6, shape (..., 7, 4, 4), of joints (..., 6)."""
        joints = np.asarray(joints, dtype=float)
        rows = np.ascontiguousarray(joints.reshape(-1, 6))
        return _chain(rows, self.flange_offset).reshape(*joints.shape[:-1], 7, 4, 4)

    def flange(self, joints: ArrayLike) -> Array:
        """Transforms T_base_flange, shape (..., 4, 4), of joint angles [rad], shape (..., 6)."""
        return self.link_frames(joints)[..., 6, :, :]

    def head(self, joints: ArrayLike) -> Array:
        """Transforms T_base_head of the scrub head, shape (..., 4, 4), of joint angles [rad] (..., 6)."""
        return self.flange(joints) @ self.tool.T_flange_head

    def jacobian(self, joints: ArrayLike) -> Array:
        """Jacobian of the scrub head in the base frame, shape (..., 6, 6): rows velocity, then rotation."""
        frames = self.link_frames(joints)
        axes = frames[..., 1:, :3, 2]
        tip = frames[..., 6, :3, 3] + self.tool.length * frames[..., 6, :3, 2]
        arms = tip[..., None, :] - frames[..., 1:, :3, 3]
        return np.concatenate([np.cross(axes, arms), axes], axis=-1).swapaxes(-1, -2)


@njit("float64[:, :, :, ::1](float64[:, ::1], float64)", cache=True, nogil=True)
def _chain(joints, flange_offset):
    """Frames of the links, shape (N, 7, 4, 4), for joint angles [rad], shape (N, 6).

    Compiled when this file is first imported on a machine, and kept: a control loop must not wait for it.
    """
    distances = (BASE_HEIGHT, 0.0, 0.0, FOREARM, 0.0, flange_offset)
    frames = np.zeros((len(joints), 7, 4, 4))
    for row in range(len(joints)):
        for index in range(4):
            frames[row, 0, index, index] = 1.0
        for link in range(6):
            before, after = frames[row, link], frames[row, link + 1]
            theta = joints[row, link] + _THETA[link]
            c, s, ca, sa = cos(theta), sin(theta), _COS_ALPHA[link], _SIN_ALPHA[link]
            a, d = _A[link], distances[link]
            for axis in range(3):
                x, y, z = before[axis, 0], before[axis, 1], before[axis, 2]
                across, along = ca * y + sa * z, ca * z - sa * y
                after[axis, 0] = c * x + s * across
                after[axis, 1] = c * across - s * x
                after[axis, 2] = along
                after[axis, 3] = before[axis, 3] + a * x + d * along
            after[3, 3] = 1.0
    return frames
