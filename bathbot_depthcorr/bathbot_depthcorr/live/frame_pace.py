"""How often frames come: their rate, when one is due for a close look, and when none come any more."""

import math

JUDGE_EVERY = 1.0
"""Time between two close looks at a frame [s]."""
SILENCE = 3.0
"""Time without frames after which the camera counts as silent [s]."""


class FramePace:
    """Counts corrected frames; times are of one monotonic clock [s].

    Attributes:
        fps: Frames per second between the last two counts.
    """

    def __init__(self, now: float) -> None:
        """Start without frames."""
        self.fps = 0.0
        self._last = (now, 0)
        self._judged = self._seen = -math.inf

    def see(self, now: float) -> bool:
        """Take note of a frame; tell whether it is time to look at it closely."""
        self._seen = now
        if now - self._judged <= JUDGE_EVERY:
            return False
        self._judged = now
        return True

    def count(self, now: float, done: int) -> bool:
        """Take the rate from the number of frames done since the start; tell whether the camera is silent."""
        before, done_before = self._last
        self.fps = (done - done_before) / (now - before)
        self._last = (now, done)
        return now - self._seen > SILENCE
