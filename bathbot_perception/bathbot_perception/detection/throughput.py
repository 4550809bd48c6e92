"""How fast and how late the detector has been during the last seconds."""

import threading
from collections import deque
from typing import NamedTuple

WINDOW = 3.0
"""Length of the time looked back on [s]."""


class Recent(NamedTuple):
    """Sums over the window; `values` are texts for diagnostics, `error` the last failure or ""."""

    pictures: int
    regions: int
    error: str
    values: dict[str, str]


class _Entry(NamedTuple):
    time: float
    duration: float
    latency: float
    regions: int


class Throughput:
    """Counts pictures; safe to use from two threads. Times are from one monotonic clock [s]."""

    def __init__(self, now: float) -> None:
        """Start at `now`."""
        self._start = now
        self._entries: deque[_Entry] = deque()
        self._error = ""
        self._lock = threading.Lock()

    def add(self, now: float, duration: float, latency: float, regions: int) -> None:
        """Count one picture that took `duration` and was sent `latency` after it was taken [s]."""
        with self._lock:
            self._entries.append(_Entry(now, duration, latency, regions))
            self._error = ""

    def fail(self, error: str) -> None:
        """Remember a failure until a picture succeeds."""
        with self._lock:
            self._error = error

    def recent(self, now: float) -> Recent:
        """Look back over the window."""
        with self._lock:
            while self._entries and self._entries[0].time < now - WINDOW:
                self._entries.popleft()
            entries, error = list(self._entries), self._error
        span = max(min(now - self._start, WINDOW), 1e-3)
        count = max(len(entries), 1)
        values = {"fps": f"{len(entries) / span:.1f}"}
        if entries:
            values["detection_ms"] = f"{1e3 * sum(e.duration for e in entries) / count:.1f}"
            values["latency_ms"] = f"{1e3 * sum(e.latency for e in entries) / count:.1f}"
            values["regions_per_picture"] = f"{sum(e.regions for e in entries) / count:.1f}"
        return Recent(len(entries), sum(e.regions for e in entries), error, values)
