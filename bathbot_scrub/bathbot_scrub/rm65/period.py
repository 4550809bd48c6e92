"""A steady beat on an absolute schedule, and how regular it really is."""

import contextlib
import os
import threading
import time
from collections import deque

import numpy as np


class PeriodStatistics:
    """Deviations of the last periods from the one wanted. One thread adds, others read."""

    def __init__(self, period: float, kept: int = 500) -> None:
        """Keep the newest `kept` periods; `period` [s] is wanted."""
        self.period = period
        self._deviations: deque[float] = deque(maxlen=kept)
        self._last: float | None = None
        self.longest = 0.0  # [s] the longest period, ever
        self.missed = 0  # periods longer than twice the one wanted, ever
        self.sent = 0

    def tick(self, now: float) -> None:
        """A command goes out now [s]."""
        if self._last is not None:
            gap = now - self._last
            self._deviations.append(abs(gap - self.period))
            self.missed += gap > 2.0 * self.period
            self.longest = max(self.longest, gap)
        self._last = now
        self.sent += 1

    def pause(self) -> None:
        """The stream rests: the gap that follows is none of its periods."""
        self._last = None

    def p99(self) -> float:
        """99th percentile of |period - wanted| [s]; 0 before the first."""
        deviations = list(self._deviations)
        return float(np.percentile(deviations, 99)) if deviations else 0.0


class Beat:
    """Falls due at start, start + period, ...; skips beats it has missed altogether."""

    def __init__(self, period: float) -> None:
        """Begin now; `period` in [s]."""
        self._period = period
        self._due = time.monotonic() + period

    def left(self) -> float:
        """Time until the next beat [s]; 0 when it is due."""
        return max(self._due - time.monotonic(), 0.0)

    def passed(self) -> bool:
        """Whether a beat is due; it is then over, and the next one comes a period later."""
        late = time.monotonic() - self._due
        if late < 0.0:
            return False
        self._due = time.monotonic() + self._period if late > self._period else self._due + self._period
        return True

    def bring_forward(self, due: float) -> None:
        """Let the next beat fall due at `due` [s] already, and the others follow from there."""
        self._due = min(self._due, max(due, time.monotonic()))


class Pulse:
    """Tells its owner how long it has stood still."""

    def __init__(self) -> None:
        """Begin now."""
        self._last = time.monotonic()

    def beat(self) -> float:
        """Time since the last call, or since the beginning [s]."""
        now = time.monotonic()
        since, self._last = now - self._last, now
        return since


def prefer_process() -> None:
    """Ask for this process and all its threads to come to be served first; not granted is no error.

    Call it before the first thread starts. The control loop alone is not enough: it waits for the
    interpreter while another thread holds it, and that thread must not be put aside meanwhile.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except (OSError, AttributeError):
        with contextlib.suppress(OSError, AttributeError):
            os.setpriority(os.PRIO_PROCESS, 0, min(os.getpriority(os.PRIO_PROCESS, 0), -10))


def raise_priority() -> str:
    """Ask for real-time scheduling of the calling thread; say what it has."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(20))
    except (OSError, AttributeError):
        try:
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), -10)
        except (OSError, AttributeError):
            return "ordinary priority (no permission for more)"
        return "nice -10"
    return "SCHED_FIFO 20"
