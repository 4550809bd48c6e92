"""Forward kinematics of the RM65 from its published modified Denavit-Hartenberg table.

Craig's convention, T(i-1, i) = Rx(alpha(i-1)) Tx(a(i-1)) Rz(q(i) + offset(i)) Tz(d(i)). The variants differ
in d6, the distance from the wrist centre to the flange: 6F carries the force sensor as an extra part,
6FB has it built in.
"""

from dataclasses import dataclass

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD, ScrubHead
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
_ALPHA = (0.0, _QUARTER, 0.0, _QUARTER, -_QUARTER, _QUARTER)
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
        frames = np.empty((*joints.shape[:-1], 7, 4, 4))
        frames[..., 0, :, :] = np.eye(4)
        distances = (BASE_HEIGHT, 0.0, 0.0, FOREARM, 0.0, self.flange_offset)
        for index in range(6):
            step = _link_transform(
                _ALPHA[index], _A[index], distances[index], joints[..., index] + _THETA[index]
            )
            frames[..., index + 1, :, :] = frames[..., index, :, :] @ step
        return frames

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


def _link_transform(alpha: float, a: float, d: float, theta: Array) -> Array:
    """One row of the table, shape (..., 4, 4), for the joint angles plus offset `theta` [rad]."""
    cos_alpha, sin_alpha = round(np.cos(alpha)), round(np.sin(alpha))  # multiples of 90 deg: exact
    cos, sin = np.cos(theta), np.sin(theta)
    step = np.zeros((*np.shape(theta), 4, 4))
    step[..., 0, 0], step[..., 0, 1], step[..., 0, 3] = cos, -sin, a
    step[..., 1, 0], step[..., 1, 1] = sin * cos_alpha, cos * cos_alpha
    step[..., 1, 2], step[..., 1, 3] = -sin_alpha, -d * sin_alpha
    step[..., 2, 0], step[..., 2, 1] = sin * sin_alpha, cos * sin_alpha
    step[..., 2, 2], step[..., 2, 3] = cos_alpha, d * cos_alpha
    step[..., 3, 3] = 1.0
    return step
