"""How the emulated joints follow what they are told: with lag, limited speed and acceleration."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.limits import JointLimits

Array = NDArray[np.float64]


class JointDynamics:
    """Six critically damped joints that chase a target.

    A ramp is followed with a lag of 2 / bandwidth. Plain floats: six joints are too few for arrays.
    """

    def __init__(self, joints: ArrayLike, limits: JointLimits, bandwidth: float = 80.0) -> None:
        """Stand still at `joints` [rad], shape (6,); `bandwidth` in [rad/s]."""
        self.positions = [float(q) for q in np.asarray(joints)]
        self.speeds = [0.0] * 6
        self._bandwidth = bandwidth
        self._speed_limits = [float(v) for v in limits.speed]
        # the controller's own default, 600 deg/s^2
        self._acceleration = math.radians(600.0)

    @property
    def joints(self) -> Array:
        """Joint angles [rad], shape (6,)."""
        return np.array(self.positions)

    def step(self, target: ArrayLike, dt: float) -> None:
        """Advance by `dt` [s] towards the target [rad], shape (6,), exact while no limit is met."""
        omega, decay = self._bandwidth, math.exp(-self._bandwidth * dt)
        most = self._acceleration * dt
        for i, goal in enumerate(target):
            position, speed, error = self.positions[i], self.speeds[i], self.positions[i] - goal
            slope = speed + omega * error
            free = (speed - omega * slope * dt) * decay
            change = min(max(free - speed, -most), most)
            limit = self._speed_limits[i]
            new = min(max(speed + change, -limit), limit)
            limited = abs(new - free) > 1e-9
            self.positions[i] = position + 0.5 * (speed + new) * dt if limited else goal + (error + slope * dt) * decay
            self.speeds[i] = new

    def at_rest(self, target: ArrayLike) -> bool:
        """Whether all joints stand at the target to 1e-4 rad and 1e-3 rad/s."""
        near = all(abs(q - goal) < 1e-4 for q, goal in zip(self.positions, target, strict=True))
        return near and all(abs(v) < 1e-3 for v in self.speeds)
