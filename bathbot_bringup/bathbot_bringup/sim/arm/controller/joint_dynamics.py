"""How the emulated joints follow what they are told: with lag, limited speed and acceleration."""

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from bathbot_scrub.arm.joint_limits import JointLimits
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
MOTOR = math.radians(600.0)  # [rad/s^2] that the motors do, the controller's own default
BRAKE = math.radians(1800.0)  # [rad/s^2] of a joint's mechanical brake; ours
NOTHING_HELD: Mapping[int, float] = MappingProxyType({})
_BRAKING = 0.8  # share of it that is counted on to stop at the target
_RATE_MEMORY = 0.7  # of the target's own speed, per step


class JointDynamics:
    """Six critically damped joints that chase a target.

    A ramp is followed with a lag of 2 / bandwidth. Plain floats: six joints are too few for arrays.
    """

    def __init__(self, joints: ArrayLike, limits: JointLimits, bandwidth: float = 80.0) -> None:
        """Stand still at `joints` [rad], shape (6,); `bandwidth` in [rad/s]."""
        self.positions = [float(q) for q in np.asarray(joints)]
        self.speeds = [0.0] * 6
        self._bandwidth = bandwidth
        self._limits = [float(v) for v in limits.speed]
        self._goals = list(self.positions)
        self._rates = [0.0] * 6
        self.travelled = [0.0] * 6  # [rad], ever

    @property
    def joints(self) -> Array:
        """Joint angles [rad], shape (6,)."""
        return np.array(self.positions)

    def step(self, target: ArrayLike, dt: float, held: Mapping[int, float] = NOTHING_HELD) -> None:
        """Advance by `dt` [s] towards the target [rad], shape (6,), exact while no limit is met.

        Joints, from 0, that are `held` brake with a deceleration [rad/s^2] instead, and stand.
        """
        omega, decay, most = self._bandwidth, math.exp(-self._bandwidth * dt), MOTOR * dt
        for i, goal in enumerate(target):
            goal, limit = float(goal), self._limits[i]
            rate = (goal - self._goals[i]) / dt
            self._goals[i] = goal
            self._rates[i] += (1.0 - _RATE_MEMORY) * (min(max(rate, -limit), limit) - self._rates[i])
            if i in held:
                self._brake(i, held[i] * dt, dt)
                continue
            speed, error = self.speeds[i], self.positions[i] - goal
            slope = speed + omega * error
            free = (speed - omega * slope * dt) * decay
            # no faster than the target itself plus what can still be braked away
            limit = min(limit, abs(self._rates[i]) + math.sqrt(2.0 * _BRAKING * MOTOR * abs(error)))
            wanted = min(max(free, -limit), limit)
            new = speed + min(max(wanted - speed, -most), most)
            if new == free:
                self.positions[i] = goal + (error + slope * dt) * decay
            else:
                self.positions[i] += 0.5 * (speed + new) * dt
            self.speeds[i] = new
            self.travelled[i] += abs(new) * dt

    def _brake(self, joint: int, slower: float, dt: float) -> None:
        """Take `slower` [rad/s] from the speed of a joint."""
        speed = self.speeds[joint]
        new = math.copysign(max(abs(speed) - slower, 0.0), speed)
        self.positions[joint] += 0.5 * (speed + new) * dt
        self.travelled[joint] += 0.5 * abs(speed + new) * dt
        self.speeds[joint], self._rates[joint] = new, 0.0

    @property
    def standing(self) -> bool:
        """Whether no joint moves at all."""
        return not any(self.speeds)

    def at_rest(self, target: ArrayLike) -> bool:
        """Whether all joints stand at the target to 1e-4 rad and 1e-3 rad/s."""
        near = all(abs(q - goal) < 1e-4 for q, goal in zip(self.positions, target, strict=True))
        return near and all(abs(v) < 1e-3 for v in self.speeds)
