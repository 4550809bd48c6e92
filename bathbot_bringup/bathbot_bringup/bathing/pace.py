"""Whether this machine keeps up with the job, judged before the arm moves towards anybody."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

_WATCH = 3.0  # [s]
_BEAT = 0.02  # [s] two periods of the arm's commands


class Arrival(NamedTuple):
    """When a picture was taken, and when what was seen in it was heard [s], by one clock."""

    taken: float
    heard: float


def enough(arrivals: Sequence[Arrival]) -> bool:
    """Whether they are enough to judge by."""
    return len(arrivals) > 1 and arrivals[-1].heard - arrivals[0].heard > _WATCH


def recent(arrivals: Sequence[Arrival]) -> Sequence[Arrival]:
    """Those of the last seconds: a machine that has just begun is slower than it will be."""
    return [arrival for arrival in arrivals if arrival.heard > arrivals[-1].heard - _WATCH]


class Pace(NamedTuple):
    """How quickly a machine sees and moves.

    Attributes:
        rate: Of what was seen [Hz].
        oldest: Age of what was known, at most [s].
        off_beat: Of the arm's commands, 99th percentile [s].
    """

    rate: float
    oldest: float
    off_beat: float

    def __str__(self) -> str:
        """In the words of the job."""
        return (
            f"the person is seen {self.rate:.1f} times a second and known {self.oldest:.1f} s old at most, "
            f"commands come {1e3 * self.off_beat:.0f} ms off their beat"
        )


def pace(arrivals: Sequence[Arrival], off_beat: float) -> Pace:
    """Measure.

    Args:
        arrivals: In order of time; of what came less than twice nothing is known.
        off_beat: 99th percentile of how far the arm's commands come off their beat [s].
    """
    if len(arrivals) < 2:
        return Pace(0.0, np.inf, off_beat)
    ages = [later.heard - before.taken for before, later in pairwise(arrivals)]
    return Pace(len(ages) / max(arrivals[-1].heard - arrivals[0].heard, 1e-9), max(ages), off_beat)


def too_slow(measured: Pace, allowed: float) -> str:
    """Why a machine cannot keep up, with the numbers; empty when it can.

    Args:
        measured: While the arm stood.
        allowed: How old what is known of the person may become then [s].
    """
    if measured.oldest > allowed:
        return f"{measured}; {allowed:.1f} s are allowed"
    if measured.off_beat > _BEAT:
        return f"{measured}; {1e3 * _BEAT:.0f} ms are allowed"
    return ""
