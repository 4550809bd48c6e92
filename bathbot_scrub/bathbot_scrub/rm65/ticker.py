"""A steady rate beside the executor, for what is published all the time.

A timer of the executor makes it gather all that it waits for anew at every tick, which costs more than what
is published: a third of a core at 50 Hz.
"""

import signal
import threading
from collections.abc import Callable

from bathbot_scrub.rm65.period import Beat


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
