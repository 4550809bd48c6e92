"""A steady beat on an absolute schedule."""

import time


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
