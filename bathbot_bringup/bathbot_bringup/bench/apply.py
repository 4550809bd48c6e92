"""Time of one correction over the time of one copy: a figure that depends little on the machine."""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.models.correction_model import Correction
from numpy.typing import NDArray

_ROUNDS, _CALLS = 15, 20


class ApplyTime(NamedTuple):
    """Medians over the rounds, of the fastest call in each.

    Attributes:
        apply_over_copy: Time of `Correction.apply` over that of a float32 copy of the same frame.
        apply_ms: Time of `Correction.apply` [ms].
        copy_ms: Time of the copy [ms].
    """

    apply_over_copy: float
    apply_ms: float
    copy_ms: float


def time_apply(correction: Correction, depth: NDArray[np.float32]) -> ApplyTime:
    """Time a correction on one frame, shape (H, W), in rounds that alternate with copies of it."""
    correction.apply(depth)  # compiles
    rounds = np.array([
        (_fastest_ms(lambda: correction.apply(depth)), _fastest_ms(depth.copy)) for _ in range(_ROUNDS)
    ])  # fmt: skip
    apply, copy = rounds.T
    return ApplyTime(*(float(np.median(values)) for values in (apply / copy, apply, copy)))


def _fastest_ms(call: Callable[[], object]) -> float:
    """Time of the fastest of some calls [ms]: the one that no other program interrupted."""
    times = []
    for _ in range(_CALLS):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1e3 * min(times)
