"""Whether the joints follow what they are told. Pure.

A joint that follows lies between where it was told to be now and a little earlier, whatever the motion;
so a late command or a late sample alone is no following error. A joint that is told to change its speed by
dv at once cannot: accelerating with a, it falls behind by dv^2 / (2 a), and that much more is allowed.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_EXPLAINED = 8  # commands, a lag of 0.07 s: the lag of the controller and of the way there and back
_WATCHED = 30  # commands, 0.3 s, in which something must have moved
_REMEMBERED = 60  # commands, 0.6 s: a change of speed that joints have not made good yet
_ACCELERATION = np.radians(600.0)  # [rad/s^2] of the joints, the controller's default
_STILL = 0.1  # share of the way commanded below which nothing has moved


class Lag(NamedTuple):
    """How far the joints are from where they could be."""

    beyond: float  # [rad] of the worst joint, outside what its commands explain; 0: inside
    lasts: int  # commands in a row for which it has been beyond the tolerance
    joint: int  # its number, 1 to 6
    told: float  # [rad] way of the joint told to go farthest, from 0.3 s ago until its lag ago
    went: float  # [rad] how far that joint went until now


NO_LAG = Lag(0.0, 0, 1, 0.0, 0.0)


class Following:
    """Compares commands and measured joints."""

    def __init__(self, tolerance: float, period: float) -> None:
        """Begin without any command; `tolerance` in [rad], `period` of the commands in [s]."""
        self._tolerance, self._period, self._lasts = tolerance, period, 0
        self._told: deque[Array] = deque(maxlen=_REMEMBERED)
        self._went: deque[Array] = deque(maxlen=_WATCHED)

    def command(self, joints: Array, measured: Array, age: float) -> Lag:
        """Take what is commanded now [rad], and what was measured `age` [s] ago, shape (6,) each."""
        explained = _EXPLAINED + int(np.ceil(min(age, 1.0) / self._period))
        self._told.append(joints)
        self._went.append(measured)
        told, went = np.array(self._told), np.array(self._went)
        lately = told[-explained:]
        speeds = np.diff(told, axis=0, prepend=told[:1]) / self._period
        behind = np.ptp(speeds, axis=0) ** 2 / (2.0 * _ACCELERATION)
        outside = np.maximum(lately.min(0) - measured, measured - lately.max(0)) - behind
        worst = int(np.argmax(outside))
        beyond = max(float(outside[worst]), 0.0)
        self._lasts = self._lasts + 1 if beyond > self._tolerance else 0
        known = explained < min(len(told), _WATCHED)  # else the sample is too old to tell anything
        earlier = told[-_WATCHED:-explained] if known else told[:1]
        way = np.ptp(earlier, axis=0)
        farthest = int(np.argmax(way))
        went_there = float(np.ptp(went[:, farthest]))
        return Lag(beyond, self._lasts, worst + 1, float(way[farthest]), went_there)

    def forget(self) -> None:
        """The stream has ended: what was commanded no longer counts."""
        self._told.clear()
        self._went.clear()
        self._lasts = 0


def stuck(lag: Lag, tolerance: float) -> bool:
    """Whether the arm was told to go farther than `tolerance` [rad] and nothing has moved."""
    return lag.told > tolerance and lag.went < _STILL * lag.told
