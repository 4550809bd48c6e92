"""Notices when the camera stands still: consecutive pictures that do not differ, and their mean."""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

LEAST_FRAMES = 2  # of colour in one still span
MOST_FRAMES = 10  # of depth: more bury nothing, as the noise of the texture is frozen
STILL = 8.0  # grey levels: the 99th percentile of what may change while nothing moves
_REDUCTION = 4


class StillSpan(NamedTuple):
    """A span of time [s] without motion, and the mean brightness of its frames, uint8, shape (H, W)."""

    start: float
    end: float
    grey: NDArray[np.uint8]
    frames: int


class StillWatch:
    """Takes colour pictures one by one and gives the spans in which nothing moved.

    Each picture is compared with the first of its span, so that a slow drift ends the span as well.
    """

    def __init__(self) -> None:
        """Begin without a picture."""
        self._first: NDArray | None = None
        self._total: NDArray | None = None
        self._start = self._end = 0.0
        self._frames = 0

    def push(self, stamp: float, colour: NDArray[np.uint8]) -> StillSpan | None:
        """Take a picture, RGB, shape (H, W, 3), of a time [s]; gives the span that it ended, if any."""
        grey = cv2.cvtColor(colour, cv2.COLOR_RGB2GRAY)
        small = cv2.resize(grey, None, fx=1 / _REDUCTION, fy=1 / _REDUCTION, interpolation=cv2.INTER_AREA)
        if self._same(small):
            self._total += grey
            self._end, self._frames = stamp, self._frames + 1
            return None
        ended = self.span()
        self._first, self._total = small, grey.astype(np.float64)
        self._start = self._end = stamp
        self._frames = 1
        return ended

    def span(self) -> StillSpan | None:
        """The span up to the last picture; None if that moved."""
        if self._frames < LEAST_FRAMES:
            return None
        mean = np.rint(self._total / self._frames).astype(np.uint8)
        return StillSpan(self._start, self._end, mean, self._frames)

    @property
    def begun(self) -> float:
        """Time of the first picture of the running span [s]."""
        return self._start

    @property
    def stood(self) -> tuple[float, int]:
        """How long nothing has moved [s], and in how many pictures."""
        return self._end - self._start, self._frames

    def _same(self, small: NDArray) -> bool:
        if self._first is None or self._first.shape != small.shape:
            return False
        return float(np.percentile(cv2.absdiff(small, self._first), 99)) <= STILL


class MeanDepth(NamedTuple):
    """Mean depth [m] of some frames, shape (H, W), their number, and noise of inverse depth [1/m]."""

    depth: NDArray[np.float32]
    frames: int
    noise: float


def mean_depth(stack: list[NDArray[np.float32]]) -> MeanDepth:
    """Average frames of one pose [m], shape (H, W) each, in inverse depth, where noise is symmetric."""
    inverse = 1.0 / np.stack(stack)
    count = np.isfinite(inverse).sum(axis=0)
    known = count >= max(1, (len(stack) + 1) // 2)
    mean = np.nansum(inverse, axis=0) / np.maximum(count, 1)
    depth = np.where(known, 1.0 / np.where(known, mean, 1.0), np.nan).astype(np.float32)
    full = count == len(stack)
    noise = float(np.median(inverse[:, full].std(axis=0, ddof=1))) if len(stack) > 1 and full.any() else 0.0
    return MeanDepth(depth, len(stack), noise)
