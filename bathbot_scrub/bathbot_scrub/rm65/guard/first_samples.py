"""What the first samples show: whether an arm that has just started stands folded, with nothing on its head.

A driver may have been started again while the brush is on the skin. Where the arm stands at home, that cannot
be; anywhere else a person must say that nothing touches the head. Pure.
"""

import math

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.states import Alarm, Reaction
from bathbot_scrub.rm65.force.wrench_filter import resultant
from bathbot_scrub.rm65.guard.force_checks import Reading
from bathbot_scrub.rm65.guard.watchdogs import UNSTEADY

Array = NDArray[np.float64]
_ENOUGH = 20  # samples, 0.1 s
_AT_HOME = 0.05  # [rad] that no joint is off


class FirstSamples:
    """Looks at some samples, and decides once."""

    def __init__(self, home: Array, free: float) -> None:
        """Compare with the home posture [rad], shape (6,), and a force that may be felt in free air [N]."""
        self._home, self._free = home, free
        self._left, self._stamp = _ENOUGH, math.nan
        self.decided = False

    def show_home(self, reading: Reading, joints: Array, alarm: Alarm) -> bool:
        """Take the newest sample, joints in [rad], shape (6,); true once, if ever: with the last of them."""
        # who has waited long for its controller is still unsteady when the first samples come
        waits = alarm.doubtful and (alarm.reaction is not Reaction.FAULT or alarm.name == UNSTEADY)
        if self.decided or waits or not math.isfinite(reading.stamp) or reading.stamp == self._stamp:
            return False
        free = resultant(reading.wrench) <= self._free and not alarm.doubtful
        home = free and bool(np.abs(joints - self._home).max() <= _AT_HOME)
        self._left, self._stamp = self._left - 1, reading.stamp
        self.decided = not home or self._left == 0
        return home and self.decided
