"""Confidence intervals over simulated units, which are drawn again with replacement."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

DRAWS = 10_000
LEVEL = 0.95


class Interval(NamedTuple):
    """A mean and the bounds of its 95 % interval; bounds are NaN for fewer than two units."""

    mean: float
    low: float
    high: float


def interval(by_unit: ArrayLike, seed: int = 0) -> Interval:
    """Percentile interval of the mean over units.

    Args:
        by_unit: One mean per unit, shape (N,).
        seed: Of the draws.
    """
    values = np.asarray(by_unit, dtype=float)
    if len(values) < 2:
        return Interval(float(values.mean()), float("nan"), float("nan"))
    draws = np.random.default_rng(seed).integers(0, len(values), (DRAWS, len(values)))
    tail = 0.5 * (1.0 - LEVEL)
    low, high = np.quantile(values[draws].mean(axis=1), (tail, 1.0 - tail))
    return Interval(float(values.mean()), float(low), float(high))


def verdict(difference: Interval) -> str:
    """Read the interval of another method's error minus ours: better, level or worse (ours)."""
    if not np.isfinite(difference.low):
        return "one unit"
    if difference.low > 0.0:
        return "better"
    return "worse" if difference.high < 0.0 else "level"
