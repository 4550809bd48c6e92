"""Keeping time: a beat that does not drift, and threads that work on it.

`Beat` says when the next is due and `Stopwatch` for how long its owner was held up; `Ticker` calls at a
steady rate; `SteadyThread` works on a beat, and at once whenever something new has come.
"""

import signal
import threading
from collections.abc import Callable

from bathbot_scrub.rm65.timing.clock import MONOTONIC
from bathbot_scrub.rm65.timing.priority import raise_priority


class Beat:
    """Falls due at start, start + period, ...; skips beats it has missed altogether."""

    def __init__(self, period: float, clock: Callable[[], float] = MONOTONIC) -> None:
        """Begin now, which `clock` tells [s]; `period` in [s]."""
        self._period, self._clock = period, clock
        self._due = clock() + period

    def left(self) -> float:
        """Time until the next beat [s]; 0 when it is due."""
        return max(self._due - self._clock(), 0.0)

    def passed(self) -> bool:
        """Whether a beat is due; it is then over, and the next one comes a period later."""
        late = self._clock() - self._due
        if late < 0.0:
            return False
        self._due = self._clock() + self._period if late > self._period else self._due + self._period
        return True

    def bring_forward(self, due: float) -> None:
        """Let the next beat fall due at `due` [s] already, and the others follow from there."""
        self._due = min(self._due, max(due, self._clock()))


class Stopwatch:
    """Tells its owner how long it has stood still."""

    def __init__(self, clock: Callable[[], float] = MONOTONIC) -> None:
        """Begin now, which `clock` tells [s]."""
        self._clock, self._last = clock, clock()

    def lap(self) -> float:
        """Time since the last call, or since the beginning [s]."""
        now = self._clock()
        since, self._last = now - self._last, now
        return since


class Ticker:
    """Calls a function at a steady rate in a thread of its own."""

    def __init__(self, rate: float, call: Callable[[], None], fail: Callable[[str], None]) -> None:
        """Begin at once.

        Args:
            rate: Calls per second [Hz].
            call: What to do.
            fail: Takes one line when `call` raises; then this process is asked to end.
        """
        self._beat, self._call, self._fail = Beat(1.0 / rate), call, fail
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="ticker", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End; no call comes after this."""
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._over.wait(self._beat.left()):
            if self._beat.passed():
                try:
                    self._call()
                except Exception as error:  # unseen, everybody would wait for ever for what comes no more
                    self._fail(f"{type(error).__name__}: {error}")
                    signal.raise_signal(signal.SIGTERM)
                    return


class SteadyThread:
    """Calls one function over and over; asks for real-time scheduling."""

    def __init__(
        self,
        name: str,
        period: float,
        work: Callable[[Beat], None],
        fail: Callable[[Exception], None],
        clock: Callable[[], float] = MONOTONIC,
    ) -> None:
        """Prepare; `start` begins.

        Args:
            name: Of the thread.
            period: Of the beat [s].
            work: Called with the beat when that is due, and when woken; whoever serves a beat passes it.
            fail: Takes whatever `work` raises; the thread goes on.
            clock: Gives the time now [s].
        """
        self.priority = ""  # what the thread has, in words
        self._period, self._work, self._fail, self._clock = period, work, fail, clock
        self._news, self._begun, self._open = threading.Event(), threading.Event(), True
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Begin to beat; when this returns, `priority` is known."""
        self._thread.start()
        self._begun.wait()

    def wake(self) -> None:
        """Something new has come: work now."""
        self._news.set()

    def once(self, beat: Beat) -> None:
        """Work now, as the thread does; for who keeps the time without a thread."""
        try:
            self._work(beat)
        except Exception as error:  # whatever it is, the next beat must come
            self._fail(error)

    def close(self) -> None:
        """End the thread."""
        self._open = False
        self._news.set()
        if self._thread.is_alive():
            self._thread.join(2.0)

    def _run(self) -> None:
        self.priority = raise_priority()
        self._begun.set()
        beat = Beat(self._period, self._clock)
        while self._open:
            self._news.wait(beat.left())
            self._news.clear()
            self.once(beat)
