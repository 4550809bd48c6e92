"""How many threads to train with while other programs come and go.

Two threads meet after every layer. On a quiet machine that halves a step; when another program
holds a core, each meeting waits for the scheduler and one thread alone is faster.
"""

from statistics import median


class Pace:
    """Tries the other number of threads now and then, and stays with the faster one."""

    def __init__(self, most: int, every: int = 60, trial: int = 5) -> None:
        """Choose between 1 and `most` threads; a trial of `trial` steps comes `every` steps."""
        self._counts = (1,) if most == 1 else (most, 1)
        self._every, self._trial = every, trial
        self._step = 0
        self._durations: dict[int, list[float]] = {count: [] for count in self._counts}

    @property
    def threads(self) -> int:
        """Threads to use for the next step."""
        return self._counts[-1] if self._trying else self._counts[0]

    @property
    def _trying(self) -> bool:
        return len(self._counts) > 1 and self._step % self._every >= self._every - self._trial

    def took(self, seconds: float) -> None:
        """Tell how long the step took [s]."""
        self._durations[self.threads].append(seconds)
        self._step += 1
        if self._step % self._every == 0 and len(self._counts) > 1:
            present, other = (self._durations[count][-self._trial + 1 :] for count in self._counts)
            if median(other) < 0.9 * median(present):
                self._counts = self._counts[::-1]
            self._durations = {count: [] for count in self._counts}
