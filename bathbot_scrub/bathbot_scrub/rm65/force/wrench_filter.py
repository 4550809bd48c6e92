"""From the sensor's wrench at the flange to the force the skin feels at the head's tip, filtered."""

from collections import deque
from typing import NamedTuple

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD, ScrubHead
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
_WINDOWS = (5, 9, 17)  # samples, 20, 40 and 80 ms at 200 Hz
_CYCLE = 0.005  # [s] of the push
_CLOSEST = 0.8  # of a cycle: samples that arrive closer together were late, not taken closer together
_GLITCH = np.array([1.0] * 3 + [0.1] * 3)  # [N, Nm] from one sample to the next; more must be seen twice
_LONGEST_STEP = 0.05  # [s]; after a longer gap the filter starts anew


class Trend(NamedTuple):
    """The straight line through the newest samples of the resultant, by least squares."""

    count: int  # of samples
    span: float  # [s] from the oldest to the newest
    force: float  # [N] of the line at the newest
    rise: float  # [N/s]


class HeadWrench(NamedTuple):
    """Wrench on the scrub head about its tip, axes of the head, [N, Nm]."""

    stamp: float  # [s] on arrival
    raw: Array  # (6,)
    filtered: Array  # (6,) median of three, then first-order low-pass
    sudden: Array  # (6,) as measured where it goes on from the sample before, else what both have at least
    trends: tuple[Trend, ...]  # over each window that is full, the shortest first

    @property
    def force(self) -> float:
        """Filtered resultant [N]."""
        return resultant(self.filtered)


def resultant(wrench: Array) -> float:
    """Length of the force [N] of a wrench, shape (6,)."""
    return float(np.sqrt(wrench[:3] @ wrench[:3]))


def at_tip(wrench: ArrayLike, head: ScrubHead = SCRUB_HEAD) -> Array:
    """Move a wrench about the flange, shape (..., 6), to the head's tip; the axes are the same."""
    wrench = np.asarray(wrench, dtype=float)
    moved = wrench.copy()
    moved[..., 3] += head.length * wrench[..., 1]
    moved[..., 4] -= head.length * wrench[..., 0]
    return moved


def common(one: Array, other: Array) -> Array:
    """What two wrenches have in common, component by component: the lesser of the same sign, else 0."""
    return np.maximum(np.minimum(one, other), 0.0) + np.minimum(np.maximum(one, other), 0.0)


def median(a: Array, b: Array, c: Array) -> Array:
    """Median of three arrays, element by element."""
    return np.maximum(np.minimum(a, b), np.minimum(np.maximum(a, b), c))


def _line(times: Array, forces: Array) -> Trend:
    """The line through forces [N] at times [s], shape (N,) each."""
    count = len(times)
    since = times - times.sum() / count
    rise = float(since @ forces / (since @ since))
    return Trend(
        count, float(since[-1] - since[0]), float(forces.sum()) / count + rise * float(since[-1]), rise
    )


class WrenchFilter:
    """Takes samples as they come; a single glitch of any size changes nothing but `raw` by more than 1 N."""

    def __init__(self, cutoff: float, head: ScrubHead = SCRUB_HEAD) -> None:
        """Cut above `cutoff` [Hz]; the wrench is that on the tip of `head`."""
        self._head = head
        self._time_constant = 1.0 / (2.0 * np.pi * cutoff)
        self._recent: deque[tuple[float, float]] = deque(maxlen=max(_WINDOWS))
        self._raws: deque[Array] = deque(maxlen=3)
        self._last: HeadWrench | None = None

    def update(self, stamp: float, wrench: ArrayLike) -> HeadWrench:
        """Take a wrench about the flange, shape (6,), that arrived at `stamp` [s].

        A wrench that is not finite is given as it is, and the filter begins anew behind it.
        """
        raw, last = at_tip(wrench, self._head), self._last
        if not np.isfinite(raw).all():
            self.reset()
            return HeadWrench(stamp, raw, raw, raw, ())
        if last is None or not 0.0 <= stamp - last.stamp < _LONGEST_STEP:
            self.reset()
            self._raws.extend((raw, raw, raw))
            filtered = raw
        else:
            self._raws.append(raw)
            gain = (stamp - last.stamp) / (stamp - last.stamp + self._time_constant)
            filtered = last.filtered + gain * (median(*self._raws) - last.filtered)
        taken = max(stamp, self._recent[-1][0] + _CLOSEST * _CYCLE) if self._recent else stamp
        before = self._raws[-2]
        sudden = np.where(np.abs(raw - before) < _GLITCH, raw, common(raw, before))
        self._recent.append((taken, resultant(sudden)))
        self._last = HeadWrench(stamp, raw, filtered, sudden, self._trends())
        return self._last

    def _trends(self) -> tuple[Trend, ...]:
        """A line over each window that is full."""
        times, forces = np.array(self._recent).T
        return tuple(_line(times[-n:], forces[-n:]) for n in _WINDOWS if n <= len(times))

    def reset(self) -> None:
        """Forget the past, as after zeroing."""
        self._recent.clear()
        self._raws.clear()
        self._last = None
