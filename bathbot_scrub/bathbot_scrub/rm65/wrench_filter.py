"""From the sensor's wrench at the flange to the force the skin feels at the head's tip, filtered."""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.kinematics import HEAD_LENGTH

Array = NDArray[np.float64]
_WINDOW = 5  # samples, 25 ms at 200 Hz: the slope's noise is then 3 N/s
_LEAST_SPREAD = 1e-4  # [s^2] of their stamps; late samples that arrive together tell no slope
_LONGEST_STEP = 0.05  # [s]; after a longer gap the filter starts anew


class HeadWrench(NamedTuple):
    """Wrench on the scrub head about its tip, axes of the head, [N, Nm]."""

    stamp: float  # [s] time.monotonic()
    raw: Array  # (6,)
    filtered: Array  # (6,) first-order low-pass
    sudden: float  # [N] resultant that two samples in a row have at least: fast, yet no single glitch
    rise: float  # [N/s] slope of the resultant over the last samples

    @property
    def force(self) -> float:
        """Filtered resultant [N]."""
        return float(np.linalg.norm(self.filtered[:3]))


def at_tip(wrench: ArrayLike) -> Array:
    """Move a wrench about the flange, shape (..., 6), to the head's tip; the axes are the same."""
    wrench = np.asarray(wrench, dtype=float)
    moved = wrench.copy()
    moved[..., 3] += HEAD_LENGTH * wrench[..., 1]
    moved[..., 4] -= HEAD_LENGTH * wrench[..., 0]
    return moved


class WrenchFilter:
    """First-order low-pass that takes samples as they come."""

    def __init__(self, cutoff: float) -> None:
        """Cut above `cutoff` [Hz]."""
        self._time_constant = 1.0 / (2.0 * np.pi * cutoff)
        self._recent: deque[tuple[float, float]] = deque(maxlen=_WINDOW)
        self._last: HeadWrench | None = None

    def update(self, stamp: float, wrench: ArrayLike) -> HeadWrench:
        """Take a wrench about the flange, shape (6,), that arrived at `stamp` [s]."""
        raw, last = at_tip(wrench), self._last
        resultant = float(np.linalg.norm(raw[:3]))
        if last is None or not 0.0 <= stamp - last.stamp < _LONGEST_STEP:
            self._recent.clear()
            filtered, before = raw, resultant
        else:
            gain = (stamp - last.stamp) / (stamp - last.stamp + self._time_constant)
            filtered, before = (
                last.filtered + gain * (raw - last.filtered),
                float(np.linalg.norm(last.raw[:3])),
            )
        self._recent.append((stamp, resultant))
        self._last = HeadWrench(stamp, raw, filtered, min(resultant, before), self._slope())
        return self._last

    def _slope(self) -> float:
        """Least-squares slope of the resultant over the window [N/s]; 0 until it is full."""
        if len(self._recent) < _WINDOW:
            return 0.0
        times, values = np.array(self._recent).T
        times = times - times.mean()
        spread = float(times @ times)
        return float(times @ values) / spread if spread > _LEAST_SPREAD else 0.0

    def reset(self) -> None:
        """Forget the past, as after zeroing."""
        self._recent.clear()
        self._last = None
