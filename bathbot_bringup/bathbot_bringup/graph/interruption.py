"""Ctrl-C that is not lost: Python drops an exception that a signal raises inside a destructor.

`interrupt` is the handler of SIGINT and SIGTERM. It raises at once, and it also leaves a note, which loops
that destroy many small objects - a node's futures, say - look at with `raise_if_interrupted`.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
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


@contextmanager
def held_back() -> Iterator[None]:
    """Let an interruption wait for the end of a block that must not be left half done."""
    if threading.current_thread() is not threading.main_thread():  # handlers run in the main thread only
        yield
        return
    came: list[int] = []
    before = {
        number: signal.signal(number, lambda number, _: came.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if came:
        signal.raise_signal(came[0])
