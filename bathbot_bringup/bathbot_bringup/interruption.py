"""Ctrl-C that is not lost: Python drops an exception that a signal raises inside a destructor.

`interrupt` is the handler of SIGINT and SIGTERM. It raises at once, and it also leaves a note, which loops
that destroy many small objects - a node's futures, say - look at with `raise_if_interrupted`.
"""

import threading
from types import FrameType

_pressed = threading.Event()


def interrupt(number: int, frame: FrameType | None) -> None:
    """Handle a signal: end whatever runs."""
    _pressed.set()
    raise KeyboardInterrupt


def forget_interruption() -> None:
    """Begin anew: what was pressed before has had its effect."""
    _pressed.clear()


def raise_if_interrupted() -> None:
    """Do what the handler meant to do, if that was lost.

    Raises:
        KeyboardInterrupt: If a signal came since `forget_interruption`.
    """
    if _pressed.is_set():
        _pressed.clear()
        raise KeyboardInterrupt
