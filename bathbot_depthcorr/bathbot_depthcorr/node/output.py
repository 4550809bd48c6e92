"""What a process writes, by way of a pipe of its own: whoever does not read it delays nobody.

A terminal that was told to stand still (Ctrl-S), a pipe whose reader has stopped, a disk that hangs: each
makes the thread that writes wait, and the C code below ROS writes with the interpreter's lock held, so that
all other threads would wait with it.
"""

import faulthandler
import fcntl
import io
import os
import select
import sys
import threading
import time
from contextlib import suppress

ROOM = 1 << 20  # [bytes] that wait for a reader; what comes beyond is lost
_REST = 0.01  # [s] between two writes: many lines cost no more than some
_LOST = b"[output] nobody read what this process wrote: lines were lost here\n"
_OUT, _ERR = 1, 2  # descriptors


class _Unhindered(io.FileIO):
    """Takes all that it is given, whether or not there is room for it."""

    def write(self, data: bytes) -> int:  # type: ignore[override]
        super().write(data)
        return len(data)


class _Channel:
    """One or two descriptors of this process, and the thread that carries what is written there."""

    def __init__(self, descriptors: tuple[int, ...]) -> None:
        self._descriptors, self.real = descriptors, os.dup(descriptors[0])
        self._read_end, write_end = os.pipe()
        with suppress(OSError):  # more than this user may have: the room is smaller
            fcntl.fcntl(write_end, fcntl.F_SETPIPE_SZ, ROOM)
        os.set_blocking(write_end, False)
        self._point_to(write_end)
        self._lost = False  # something that was not read yet found no room
        self._thread = threading.Thread(target=self._carry, name="output", daemon=True)
        self._thread.start()

    def close(self, deadline: float) -> None:
        self._lost = self._full()
        self._point_to(os.open(os.devnull, os.O_WRONLY))  # the last write end is gone: the thread ends
        self._thread.join(max(deadline - time.monotonic(), 0.0))

    def _point_to(self, target: int) -> None:
        for descriptor in self._descriptors:
            os.dup2(target, descriptor)
        os.close(target)

    def _full(self) -> bool:
        return not select.select([], self._descriptors[:1], [], 0.0)[1]

    def _carry(self) -> None:
        while True:
            lost = self._full() or self._lost
            data, self._lost = os.read(self._read_end, ROOM), False
            if not data:
                return
            with suppress(OSError):  # nobody can read it any more, but it must go somewhere
                self._write(data + _LOST if lost else data)
            time.sleep(_REST)

    def _write(self, data: bytes) -> None:
        while data:
            try:
                data = data[os.write(self.real, data) :]
            except BlockingIOError:  # someone else who shares it does not want to wait
                select.select([], [self.real], [])


class Output:
    """Stands between this process and its standard output and error until it is closed.

    The descriptors it found are never changed: who started this process shares them.
    """

    def __init__(self) -> None:
        """Begin."""
        if os.isatty(_ERR):
            os.environ.setdefault("RCUTILS_COLORIZED_OUTPUT", "1")  # ROS sees no terminal any more
        sys.stdout.flush()
        sys.stderr.flush()
        together = os.path.sameopenfile(_OUT, _ERR)  # then lines stay in order
        self._channels = [_Channel(part) for part in ([(_ERR, _OUT)] if together else [(_ERR,), (_OUT,)])]
        self.tell_crashes()
        self._before = sys.stdout, sys.stderr
        sys.stdout, sys.stderr = _text(_OUT), _text(_ERR)

    def tell_crashes(self) -> None:
        """Have a crash told where it would have been: the thread that carries does not outlive it."""
        faulthandler.enable(self._channels[0].real)

    def close(self, patience: float) -> None:
        """Carry what waits, for at most `patience` [s]; what is written afterwards is lost."""
        sys.stdout.flush()
        sys.stderr.flush()
        deadline = time.monotonic() + patience
        for channel in self._channels:
            channel.close(deadline)


def _text(descriptor: int) -> io.TextIOWrapper:
    raw = _Unhindered(descriptor, "wb", closefd=False)
    return io.TextIOWrapper(io.BufferedWriter(raw), errors="backslashreplace", line_buffering=True)
