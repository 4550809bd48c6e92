"""An end that a person or the system asks for, and that is not lost: Ctrl-C, SIGTERM, a closed terminal.

Python drops an exception that a signal raises inside a destructor. So `interrupt`, the handler, raises at
once and also leaves a note, which loops that destroy many small objects - a node's futures, say - look at
with `raise_if_interrupted`.
"""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_WORDS = {
    signal.SIGINT: "interrupted by Ctrl-C",
    signal.SIGTERM: "ended by SIGTERM",
    signal.SIGHUP: "the terminal was closed",
}
_came: list[int] = []
_last: list[int] = [signal.SIGINT]  # signals up to now
_terminals: list[int] = []  # of the streams in, out and error


class Interrupted(KeyboardInterrupt):
    """Somebody asked this program to end."""

    def __init__(self, number: int) -> None:
        """Say how, by the number of the signal."""
        super().__init__(_WORDS[signal.Signals(number)])


def heed_signals() -> None:
    """Have the main thread end on each of `SIGNALS`, also where a shell started it with Ctrl-C ignored.

    Who starts a program with `nohup` wants it to outlive the terminal.
    """
    _terminals[:] = filter(os.isatty, range(3))
    for number in SIGNALS:
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, interrupt)


def interrupt(number: int, frame: FrameType | None) -> None:
    """Handle a signal: end whatever runs."""
    _came.append(number)
    _last.append(number)
    if number == signal.SIGHUP:
        _let_go_of_terminal()
    raise Interrupted(number)


def _let_go_of_terminal() -> None:
    """What is still to be said goes nowhere: to write to a closed terminal is an error."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in _terminals:  # one that is gone is a terminal no more
        os.dup2(nowhere, stream)
    os.close(nowhere)


def interrupted_code() -> int:
    """What a shell expects of a program that a signal has ended: by the one that came last."""
    return 128 + _last[-1]


def forget_interruption() -> None:
    """Begin anew: what was asked before has had its effect."""
    _came.clear()


def raise_if_interrupted() -> None:
    """Do what the handler meant to do, if that was lost.

    Raises:
        Interrupted: If a signal came since `forget_interruption`.
    """
    if _came:
        number = _came[0]
        _came.clear()
        raise Interrupted(number)


@contextmanager
def held_back() -> Iterator[None]:
    """Let an interruption wait for the end of a block that must not be left half done."""
    if threading.current_thread() is not threading.main_thread():  # handlers run in the main thread only
        yield
        return
    came: list[int] = []
    before = {number: signal.signal(number, lambda number, _: came.append(number)) for number in SIGNALS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if came:
        signal.raise_signal(came[0])
