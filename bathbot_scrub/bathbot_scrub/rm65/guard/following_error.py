"""Whether the joints follow what they are told. Pure.

A joint that follows lies between where it was told to be now and a little earlier, whatever the motion;
so a late command or a late sample alone is no following error. A joint that is told to change its speed by
dv at once cannot: accelerating with a, it falls behind by dv^2 / (2 a), and that much more is allowed.

A joint that turns slowly takes long to fall behind. So a joint that was told to go on and on, whatever lag
explains, and hardly moved is found by that alone.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_EXPLAINED = 8  # commands, a lag of 0.07 s: the lag of the controller and of the way there and back
_REMEMBERED = 60  # commands, 0.6 s: a change of speed that joints have not made good yet
_ACCELERATION = np.radians(600.0)  # [rad/s^2] of the joints, the controller's default
_SPANS = (5, 10, 15)  # commands, 0.05 to 0.15 s, within which a joint must have moved
_STILL = 0.1  # share of the way commanded below which nothing has moved


class Lag(NamedTuple):
    """How far the joints are from where they could be."""

    beyond: float  # [rad] of the worst joint, outside what its commands explain; 0: inside
    lasts: int  # commands in a row for which it has been beyond the tolerance
    joint: int  # its number, 1 to 6
    still: int = 1  # number of the joint that was told most in vain
    told: float = 0.0  # [rad] the least that it was told to go, whatever its lag
    went: float = 0.0  # [rad] how far it went


NO_LAG = Lag(0.0, 0, 1)


class FollowingMonitor:
    """Compares commands and measured joints."""

    def __init__(self, tolerance: float, period: float) -> None:
        """Begin without any command; `tolerance` in [rad], `period` of the commands in [s]."""
        self._tolerance, self._period, self._lasts = tolerance, period, 0
        self._told: deque[Array] = deque(maxlen=_REMEMBERED)
        self._went: deque[Array] = deque(maxlen=max(_SPANS) + 1)

    def command(self, joints: Array, measured: Array, age: float) -> Lag:
        """Take what is commanded now [rad], and what was measured `age` [s] ago, shape (6,) each."""
        late = int(np.ceil(min(age, 1.0) / self._period))
        explained = _EXPLAINED + late
        self._told.append(joints)
        self._went.append(measured)
        told = np.array(self._told)
        lately = told[-explained:]
        speeds = np.diff(told, axis=0, prepend=told[:1]) / self._period
        behind = np.ptp(speeds, axis=0) ** 2 / (2.0 * _ACCELERATION)
        outside = np.maximum(lately.min(0) - measured, measured - lately.max(0)) - behind
        worst = int(np.argmax(outside))
        beyond = max(float(outside[worst]), 0.0)
        self._lasts = self._lasts + 1 if beyond > self._tolerance else 0
        return Lag(beyond, self._lasts, worst + 1, *self._in_vain(told, explained, late))

    def _in_vain(self, told: Array, explained: int, late: int) -> tuple[int, float, float]:
        """The joint that was told to go farthest and did not: its number, the way told, the way gone."""
        went, found = np.array(self._went), (1, 0.0, 0.0)
        for span in _SPANS:
            # an old sample shows less of the way
            if span < 2 * late or span + explained >= len(told) or span >= len(went):
                continue
            ways = (told[span:] - told[:-span])[-explained - 1 :]
            least = np.where(np.ptp(np.sign(ways), axis=0) == 0.0, np.abs(ways).min(axis=0), 0.0)
            gone = np.ptp(went[-span - 1 :], axis=0)
            vain = np.where(gone < _STILL * least, least, 0.0)
            joint = int(np.argmax(vain))
            if vain[joint] > found[1]:
                found = (joint + 1, float(vain[joint]), float(gone[joint]))
        return found

    def forget(self) -> None:
        """The stream has ended: what was commanded no longer counts."""
        self._told.clear()
        self._went.clear()
        self._lasts = 0
