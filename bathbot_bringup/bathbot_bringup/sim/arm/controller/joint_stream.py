"""Targets that clients stream to the emulated arm, and how they are smoothed.

What firmware does in the modes "curve fit" and "filter" is not published: both are a first-order low pass
here, and the longest lags are those of the vendor's manual.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
END = 0.1  # [s] without frames after which a stream is over
LARGEST_STEP = np.radians(10.0)  # per frame; else the joint does not respond
_FITTED = 0.15  # [s] of lag at mode 1 and radio 100: 15 periods of 10 ms
_FILTERED = 0.5  # [s] of lag at mode 2 and radio 1000
_LOW_FOLLOW = 0.05  # [s] of lag without "follow"


def lag(follow: bool, mode: int, radio: int) -> float:
    """Time constant [s] of a stream: low follow, or a trajectory_mode and its radio."""
    if not follow:
        return _LOW_FOLLOW
    return {1: _FITTED * min(radio, 100) / 100.0, 2: _FILTERED * min(radio, 1000) / 1000.0}.get(mode, 0.0)


class JointStream:
    """The goal that was streamed last, and the way there."""

    def __init__(self, period: float) -> None:
        """Begin without any; `period` [s] is the time of one step."""
        self._period = period
        self._goal: Array | None = None
        self._lag = 0.0
        self._speed: Array | None = None
        self._age = 0.0

    @property
    def alive(self) -> bool:
        """Whether a frame came a short while ago."""
        return self._goal is not None and self._age <= END

    def take(self, goal: Array, time_constant: float = 0.0, speed: Array | None = None) -> None:
        """Take a goal [rad], shape (6,), smoothed by a time constant [s] or led to at a speed [rad/s]."""
        self._goal, self._lag, self._speed, self._age = goal, time_constant, speed, 0.0

    def forget(self) -> None:
        """End the stream; nothing moves on."""
        self._goal = None

    def step(self, target: Array) -> Array:
        """Advance the target [rad], shape (6,), by one period."""
        if self._goal is None:
            return target
        self._age += self._period
        way = self._goal - target
        if self._speed is not None:
            most = self._speed * self._period
            return target + np.clip(way, -most, most)
        if self._lag > 0.0:
            return target + way * -np.expm1(-self._period / self._lag)
        return self._goal.copy()
