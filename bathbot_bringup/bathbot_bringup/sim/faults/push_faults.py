"""What becomes of state datagrams on their way out: one function a fault.

Each takes the newest datagram, the outbox and the time [s], and gives the datagram that takes its place, or
None where none shall leave.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

from bathbot_bringup.sim.faults.lasting_fault import LastingFault


class Datagram(NamedTuple):
    """One state, ready to be sent."""

    data: bytes
    force: float  # [N] resultant of the zeroed force in it


class Outbox:
    """Datagrams that wait to leave; without a fault none does.

    Attributes:
        last: When one was let through last [s].
        wait: How long the first that waits must wait yet another time [s].
    """

    def __init__(self) -> None:
        """Begin empty."""
        self.last, self.wait = -math.inf, 0.0
        self._held: list[Datagram] = []
        self._held_since = -math.inf

    def leaving(self, state: Datagram, now: float, faults: Iterable[LastingFault]) -> list[Datagram]:
        """What leaves at `now` [s] when `state` is to be sent and `faults` of the push last."""
        self.wait = 0.0
        for fault in faults:
            told = fault(state, self, now)
            if told is None:
                return []
            state = told
        self.last = now
        if not self._held:
            self._held_since = now
        self._held.append(state)
        if now - self._held_since < self.wait:
            return []
        leaving, self._held = self._held, []
        return leaving


def lost(fault: LastingFault, state: Datagram, outbox: Outbox, now: float) -> None:
    """Let none leave."""


def slow(fault: LastingFault, state: Datagram, outbox: Outbox, now: float) -> Datagram | None:
    """Let one leave in its value [s]."""
    return None if now - outbox.last < fault.value else state


def repeated(fault: LastingFault, state: Datagram, outbox: Outbox, now: float) -> Datagram:
    """Send the datagram again with which the fault began."""
    return fault.memory.setdefault("first", state)


def cut_short(fault: LastingFault, state: Datagram, outbox: Outbox, now: float) -> Datagram:
    """Send the first half."""
    return Datagram(state.data[: len(state.data) // 2], math.nan)


def held_back(fault: LastingFault, state: Datagram, outbox: Outbox, now: float) -> Datagram:
    """Hold datagrams back for its value [s], then send them all."""
    outbox.wait = fault.value
    return state
