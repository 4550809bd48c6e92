"""A thread that works on a steady beat, and at once whenever something new has come."""

import threading
from collections.abc import Callable

from bathbot_scrub.rm65.period import Beat
from bathbot_scrub.rm65.priority import raise_priority


class SteadyThread:
    """Calls one function over and over; asks for real-time scheduling."""

    def __init__(
        self, name: str, period: float, work: Callable[[Beat], None], fail: Callable[[Exception], None]
    ) -> None:
        """Prepare; `start` begins.

        Args:
            name: Of the thread.
            period: Of the beat [s].
            work: Called with the beat when that is due, and when woken; whoever serves a beat passes it.
            fail: Takes whatever `work` raises; the thread goes on.
        """
        self.priority = ""  # what the thread has, in words
        self._period, self._work, self._fail = period, work, fail
        self._news, self._open = threading.Event(), True
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Begin to beat."""
        self._thread.start()

    def wake(self) -> None:
        """Something new has come: work now."""
        self._news.set()

    def close(self) -> None:
        """End the thread."""
        self._open = False
        self._news.set()
        if self._thread.is_alive():
            self._thread.join(2.0)

    def _run(self) -> None:
        self.priority = raise_priority()
        beat = Beat(self._period)
        while self._open:
            self._news.wait(beat.left())
            self._news.clear()
            try:
                self._work(beat)
            except Exception as error:  # whatever it is, the next beat must come
                self._fail(error)
