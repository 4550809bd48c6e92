"""What a faulty force sensor says instead of the truth."""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.faults.fault_schedule import FaultSchedule

Array = NDArray[np.float64]
_REMEMBERED = 5.0  # [s] of readings, for a stale one


class ForceReading(NamedTuple):
    """One reading in the sensor frame, [N, Nm], shape (6,)."""

    raw: Array  # with weight and bias
    zero: Array  # external force, as the controller compensates it


class ForceFaults:
    """Spoils the readings of the force sensor, one per step."""

    def __init__(self, faults: FaultSchedule, period: float) -> None:
        """Look at `faults` at every reading; `period` [s] between them."""
        self._faults, self._period = faults, period
        self._past: deque[ForceReading] = deque(maxlen=round(_REMEMBERED / period) + 1)
        self._frozen: ForceReading | None = None
        self._drift = 0.0

    def spoil(self, true: ForceReading) -> ForceReading:
        """What is said instead of a true reading."""
        faults = self._faults
        self._past.append(true)
        self._drift = self._drift + faults.value("drifting_force") * self._period if (
            "drifting_force" in faults) else 0.0  # fmt: skip
        said = true
        if "stale_force" in faults:
            said = self._past[-min(round(faults.value("stale_force") / self._period) + 1, len(self._past))]
        if "biased_force" in faults or self._drift:
            bias = (faults.value("biased_force") if "biased_force" in faults else 0.0) + self._drift
            said = ForceReading(*(_with_z(wrench, wrench[2] + bias) for wrench in said))
        if "saturated_force" in faults:
            said = ForceReading(*(_with_z(wrench, faults.value("saturated_force")) for wrench in said))
        if "frozen_force" in faults:
            said = self._frozen = self._frozen or said
        else:
            self._frozen = None
        if "dead_force" in faults:
            said = ForceReading(np.zeros(6), np.zeros(6))
        if "nan_force" in faults:
            said = ForceReading(np.full(6, np.nan), np.full(6, np.nan))
        return said


def _with_z(wrench: Array, force: float) -> Array:
    wrench = wrench.copy()
    wrench[2] = force
    return wrench
