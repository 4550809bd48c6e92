"""How regular the stream of commands is, how soon it answers to force, and the log that accounts for both."""

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


class ReactionStatistics:
    """The newest answers. One thread adds, others read."""

    def __init__(self, kept: int = 1000) -> None:
        """Keep the newest `kept` answers."""
        self._times: deque[float] = deque(maxlen=kept)
        self.longest = 0.0  # [s] ever

    def add(self, seconds: float) -> None:
        """An answer took so long [s]."""
        self._times.append(seconds)
        self.longest = max(self.longest, seconds)

    @property
    def count(self) -> int:
        """How many are kept."""
        return len(self._times)

    def p99(self) -> float:
        """99th percentile [s]; 0 before the first."""
        times = list(self._times)
        return float(np.percentile(times, 99)) if times else 0.0


class CommandLog:
    """Accounts for the stream of commands. One thread writes, others read the statistics."""

    def __init__(self, period: float) -> None:
        """Nothing was sent yet; `period` [s] is wanted."""
        self.statistics, self.reactions = PeriodStatistics(period), ReactionStatistics()
        self.last = 0.0  # [s] when the last command went out
        self._over_since: float | None = None  # [s] stamp of the sample that is being answered

    def answer(self, over_since: float | None) -> None:
        """The next command answers to a force whose first sample came at `over_since` [s]."""
        self._over_since = over_since

    def sent(self, now: float) -> None:
        """A command went out now [s]."""
        if self._over_since is not None:
            self.reactions.add(now - self._over_since)
            self.statistics.pause()  # this one came early, on purpose
            self._over_since = None
        self.last = now
        self.statistics.tick(now)

    def pause(self) -> None:
        """The stream rests."""
        self.statistics.pause()
