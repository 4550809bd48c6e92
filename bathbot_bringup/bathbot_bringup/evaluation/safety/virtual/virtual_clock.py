"""Time that passes only when somebody waits: what is due happens one thing after the other, in one thread."""

import heapq
import itertools
import math
import threading
from collections.abc import Callable

from bathbot_scrub.rm65.timing.clock import Clock

_BEGIN = 100.0  # [s]: nothing may take zero for the beginning of time


class VirtualClock(Clock):
    """A clock and what it is to bring about."""

    def __init__(self) -> None:
        """Begin with nothing to come."""
        self._now, self._order = _BEGIN, itertools.count()
        self._coming: list[tuple[float, int, Callable[[], None]]] = []

    def __call__(self) -> float:
        """Now [s]."""
        return self._now

    def at(self, when: float, action: Callable[[], None]) -> None:
        """Have something happen at `when` [s], behind what was ordered for that instant before."""
        heapq.heappush(self._coming, (when, next(self._order), action))

    def step(self, until: float) -> bool:
        """Let the next thing happen that is due by `until` [s]; when there is none, it is `until`."""
        if not self._coming or self._coming[0][0] > until:
            self._now = max(self._now, until)
            return False
        when, _, action = heapq.heappop(self._coming)
        self._now = max(self._now, when)
        action()
        return True

    def sleep(self, seconds: float) -> None:
        """Let time pass [s]."""
        until = self._now + seconds
        while self.step(until):
            pass

    def until(self, condition: Callable[[], bool], timeout: float = math.inf) -> bool:
        """Let time pass until something holds, or for `timeout` [s]; tell whether it holds."""
        end = self._now + timeout
        while not (holds := condition()):
            if not self.step(end):
                return condition()
        return holds

    def condition(self) -> threading.Condition:
        """A lock whose holder lets time pass by waiting."""
        return _Waiting(self)


class _Waiting(threading.Condition):
    def __init__(self, clock: VirtualClock) -> None:
        super().__init__(threading.RLock())
        self._clock, self._told = clock, 0

    def wait(self, timeout: float | None = None) -> bool:
        told = self._told
        return self._clock.until(lambda: self._told > told, math.inf if timeout is None else timeout)

    def wait_for(self, predicate: Callable[[], bool], timeout: float | None = None) -> bool:
        return self._clock.until(predicate, math.inf if timeout is None else timeout)

    def notify(self, n: int = 1) -> None:
        self._told += 1

    def notify_all(self) -> None:
        self._told += 1
