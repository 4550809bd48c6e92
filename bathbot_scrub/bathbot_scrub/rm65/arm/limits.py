"""What the joints of the RM65 may do: the data sheet's angles and speeds, and gentler ones of ours."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.errors import JointLimitError

Array = NDArray[np.float64]
_SPEED_SLACK = 1.05  # for rounding of the period


def _degrees(*values: float) -> Array:
    angles = np.radians(values)
    angles.setflags(write=False)
    return angles


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits of six joints, arrays of shape (6,).

    Angles and speeds are the data sheet's. The controller's default acceleration is 600 deg/s^2; a
    person sits in reach, so ours is far lower, and the jerk is chosen to reach it in 0.1 s.
    """

    lower: Array = field(default_factory=lambda: _degrees(-178, -130, -135, -178, -128, -360))  # [rad]
    upper: Array = field(default_factory=lambda: _degrees(178, 130, 135, 178, 128, 360))  # [rad]
    speed: Array = field(default_factory=lambda: _degrees(180, 180, 225, 225, 225, 225))  # [rad/s]
    acceleration: Array = field(default_factory=lambda: _degrees(*[200] * 6))  # [rad/s^2]
    jerk: Array = field(default_factory=lambda: _degrees(*[2000] * 6))  # [rad/s^3]

    def contain(self, joints: ArrayLike, margin: float = 0.0) -> NDArray[np.bool_]:
        """Tell which joint vectors [rad], shape (..., 6), lie inside by `margin` [rad]; NaN does not."""
        joints = np.asarray(joints, dtype=float)
        return np.all((joints >= self.lower + margin) & (joints <= self.upper - margin), axis=-1)

    def check(self, joints: ArrayLike) -> None:
        """Refuse a joint vector [rad], shape (6,), outside the limits.

        Raises:
            JointLimitError: With the first joint outside and its nearest limit.
        """
        joints = np.asarray(joints, dtype=float)
        for index, (value, lower, upper) in enumerate(zip(joints, self.lower, self.upper, strict=True)):
            if not lower <= value <= upper:
                raise JointLimitError(
                    "angle [rad]", index + 1, float(value), float(upper if value > 0 else lower)
                )

    def check_step(self, before: ArrayLike, after: ArrayLike, period: float) -> None:
        """Refuse a command that asks for more speed than a joint has, or for no number.

        Args:
            before: Joints last commanded [rad], shape (6,).
            after: Joints to be commanded next.
            period: Time between the two [s].

        Raises:
            JointLimitError: With the joint that would be fastest and its limit.
        """
        speed = (np.asarray(after, dtype=float) - np.asarray(before, dtype=float)) / period
        share = np.abs(speed) / self.speed
        if not (share <= _SPEED_SLACK).all():
            worst = int(np.argmax(np.where(np.isfinite(share), share, np.inf)))
            raise JointLimitError("speed [rad/s]", worst + 1, float(speed[worst]), float(self.speed[worst]))


RM65_LIMITS = JointLimits()
HOME_DEG = (0.0, 60.0, -130.0, 0.0, -80.0, 0.0)
"""Folded posture out of the camera's view [deg]."""
