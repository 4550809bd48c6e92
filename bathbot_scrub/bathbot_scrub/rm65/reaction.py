"""How long the arm takes to answer to force: from the sample's arrival to the command on the wire."""

from collections import deque

import numpy as np


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
