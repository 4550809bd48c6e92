"""What the joints of an arm may do."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.errors import JointLimitError

Array = NDArray[np.float64]
_SPEED_SLACK = 1.05  # for rounding of the period


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits of all joints, read-only arrays of shape (J,)."""

    lower: Array  # [rad]
    upper: Array  # [rad]
    speed: Array  # [rad/s]
    acceleration: Array  # [rad/s^2]
    jerk: Array  # [rad/s^3]

    def __post_init__(self) -> None:
        """Keep copies that nobody can write to."""
        for name in ("lower", "upper", "speed", "acceleration", "jerk"):
            values = np.array(getattr(self, name), dtype=float)
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    def contain(self, joints: ArrayLike, margin: float = 0.0) -> NDArray[np.bool_]:
        """Tell which joint vectors [rad], shape (..., J), lie inside by `margin` [rad]; NaN does not."""
        joints = np.asarray(joints, dtype=float)
        return np.all((joints >= self.lower + margin) & (joints <= self.upper - margin), axis=-1)

    def check(self, joints: ArrayLike) -> None:
        """Refuse a joint vector [rad], shape (J,), outside the limits.

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
            before: Joints last commanded [rad], shape (J,).
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
