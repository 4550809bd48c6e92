"""A wire of virtual time: what goes in comes out a little later, in order."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from bathbot_bringup.evaluation.safety.virtual.virtual_clock import VirtualClock


class Delay(NamedTuple):
    """How long one way takes: never less than `least` [s], and up to `jitter` [s] more, evenly drawn.

    Half a millisecond to two and a half, for the network and for the program that sends.
    """

    least: float = 0.0005
    jitter: float = 0.0020


class Wire:
    """One direction."""

    def __init__(self, clock: VirtualClock, rng: np.random.Generator, delay: Delay) -> None:
        """Lay it; `rng` draws the jitter."""
        self._clock, self._rng, self._delay = clock, rng, delay
        self._last = clock()

    def send(self, arrive: Callable[[], None], later: float = 0.0) -> None:
        """Have something arrive in due time, `later` [s] than usual; nothing overtakes."""
        way = self._delay.least + self._delay.jitter * float(self._rng.uniform()) + later
        self._last = max(self._last, self._clock() + way)
        self._clock.at(self._last, arrive)
