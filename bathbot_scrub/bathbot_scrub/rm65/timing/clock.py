"""Time as the driver's parts see it: what it is now, sleeping, and waiting for news.

All that stamps, times or waits takes its time from one `Clock`. A test may hand over one that it advances
itself: then no second passes while the arm lives one, and the same seed gives the same life again.
"""

import threading
import time


class Clock:
    """The machine's own."""

    def __call__(self) -> float:
        """Now [s], from some beginning; never goes back, whatever is done to the time of day.

        It goes on while the machine sleeps, as `time.monotonic` does not: what was seen before is old then.
        """
        return time.clock_gettime(time.CLOCK_BOOTTIME)

    def sleep(self, seconds: float) -> None:
        """Let time pass [s] in the calling thread."""
        time.sleep(seconds)

    def condition(self) -> threading.Condition:
        """A lock that its owner may take again, and whose holder may wait for news."""
        return threading.Condition(threading.RLock())


MONOTONIC = Clock()
