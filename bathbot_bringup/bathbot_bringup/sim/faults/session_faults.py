"""What is wrong with the connections of the clients: one function a fault."""

from collections.abc import Iterable
from typing import NamedTuple

from bathbot_bringup.sim.faults.lasting_fault import LastingFault


class SessionTrouble(NamedTuple):
    """What is wrong with a connection just now."""

    cut_off: bool = False  # a new one ends at once
    deaf: bool = False  # nothing is heard, nothing answered
    waiting: bool = False  # what comes is read later
    delay: float = 0.0  # [s] of what is sent


def session_trouble(faults: Iterable[LastingFault]) -> SessionTrouble:
    """All that is wrong while `faults` of the sessions last."""
    troubles = [SessionTrouble(), *(fault() for fault in faults)]
    return SessionTrouble(*(max(of_all) for of_all in zip(*troubles, strict=True)))


def cut_off(fault: LastingFault) -> SessionTrouble:
    """End new connections."""
    return SessionTrouble(cut_off=True)


def deaf(fault: LastingFault) -> SessionTrouble:
    """Answer nothing and obey nothing."""
    return SessionTrouble(deaf=True)


def waiting(fault: LastingFault) -> SessionTrouble:
    """Read later what comes now."""
    return SessionTrouble(waiting=True)


def late(fault: LastingFault) -> SessionTrouble:
    """Send its value [s] late."""
    return SessionTrouble(delay=fault.value)
