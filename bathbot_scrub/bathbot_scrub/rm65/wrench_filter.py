"""From the sensor's wrench at the flange to the force the skin feels at the head's tip, filtered."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.kinematics import HEAD_LENGTH

Array = NDArray[np.float64]
_LONGEST_STEP = 0.05  # [s]; after a longer gap the filter starts anew


class HeadWrench(NamedTuple):
    """Wrench on the scrub head about its tip, axes of the head, [N, Nm]."""

    stamp: float     # [s] time.monotonic()
    raw: Array       # (6,)
    filtered: Array  # (6,) first-order low-pass
    sudden: float    # [N] resultant that two samples in a row have at least: fast, yet no single glitch

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
        self._last: HeadWrench | None = None

    def update(self, stamp: float, wrench: ArrayLike) -> HeadWrench:
        """Take a wrench about the flange, shape (6,), that arrived at `stamp` [s]."""
        raw, last = at_tip(wrench), self._last
        resultant = float(np.linalg.norm(raw[:3]))
        if last is None or not 0.0 <= stamp - last.stamp < _LONGEST_STEP:
            self._last = HeadWrench(stamp, raw, raw, resultant)
        else:
            step = stamp - last.stamp
            gain = step / (step + self._time_constant)
            before = float(np.linalg.norm(last.raw[:3]))
            self._last = HeadWrench(stamp, raw, last.filtered + gain * (raw - last.filtered), min(resultant, before))
        return self._last

    def reset(self) -> None:
        """Forget the past, as after zeroing."""
        self._last = None
