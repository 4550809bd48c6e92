"""The height of breathing skin to plan on.

A segment is followed seconds after it was planned, about half a breath: planned on the newest
height it could be off by twice the breath's amplitude. So plans stand on the mean of the last
breaths as soon as they are known. A height that leaves what the last breaths have shown, at once or
little by little, is a move of the body: it is followed, and the breaths before it are forgotten.
"""

import numpy as np

_JUMP = 0.0015  # beyond all heights of the last breaths [m]; a breath takes longer between two pictures
_KNOWN = 0.5  # share of the window from which the mean counts


class SkinLevel:
    """Heights of the skin over time, along the normal."""

    def __init__(self, window: float, spread: float) -> None:
        """Begin without any height.

        Args:
            window: Time over which is averaged: a breath or two [s].
            spread: Of the newest height from the mean, beyond which the body has moved [m].
        """
        self._window, self._spread = window, spread
        self._times: list[float] = []
        self._heights: list[float] = []

    def add(self, time: float, height: float) -> None:
        """Take in a height [m] at a time [s]; one older than the newest only fills the past."""
        if self._times and time < self._times[-1]:
            index = int(np.searchsorted(self._times, time))
            self._times.insert(index, time)
            self._heights.insert(index, height)
            return
        if self._heights and not self._familiar(height):
            self._times, self._heights = [], []
        self._times.append(time)
        self._heights.append(height)
        while self._times[0] < time - self._window:
            del self._times[0], self._heights[0]

    @property
    def level(self) -> float:
        """The height to plan on [m]: the mean where enough of a breath is known, else the newest."""
        newest, known = self._heights[-1], self._times[-1] - self._times[0] >= _KNOWN * self._window
        mean = float(np.mean(self._heights))
        return mean if known and abs(newest - mean) <= self._spread else newest

    def _familiar(self, height: float) -> bool:
        return min(self._heights) - _JUMP <= height <= max(self._heights) + _JUMP
