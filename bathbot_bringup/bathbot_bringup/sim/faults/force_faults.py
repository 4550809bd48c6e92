"""What a faulty force sensor says instead of the truth: one function a fault.

Each takes the reading as it stands and the true ones up to now, and gives the reading that is said instead.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.faults.lasting_fault import LastingFault

Array = NDArray[np.float64]
SENSOR_GONE = 0x2003  # the controller's error code
_REMEMBERED = 5.0  # [s] of readings, for a stale one


class ForceReading(NamedTuple):
    """One reading in the sensor frame, [N, Nm], shape (6,)."""

    raw: Array  # with weight and bias
    zero: Array  # external force, as the controller compensates it
    error: int = 0  # of the sensor, 0: none


class ForceHistory:
    """The true readings of the last seconds, one a step.

    Attributes:
        period: Of a step [s].
    """

    def __init__(self, period: float) -> None:
        """Begin without any; `period` [s] between them."""
        self.period = period
        self._readings: deque[ForceReading] = deque(maxlen=round(_REMEMBERED / period) + 1)

    def keep(self, reading: ForceReading) -> None:
        """Add the newest."""
        self._readings.append(reading)

    def before(self, seconds: float) -> ForceReading:
        """The reading of some time ago [s], or the oldest there is."""
        return self._readings[-min(round(seconds / self.period) + 1, len(self._readings))]


def stale(fault: LastingFault, said: ForceReading, history: ForceHistory) -> ForceReading:
    """Say what was true some time ago; its value in s."""
    return history.before(fault.value)


def biased(fault: LastingFault, said: ForceReading, history: ForceHistory) -> ForceReading:
    """Add its value [N] along z."""
    return _raised(said, fault.value)


def drifting(fault: LastingFault, said: ForceReading, history: ForceHistory) -> ForceReading:
    """Add more and more along z; its value in N/s."""
    fault.memory["drift"] = fault.memory.get("drift", 0.0) + fault.value * history.period
    return _raised(said, fault.memory["drift"])


def saturated(fault: LastingFault, said: ForceReading, history: ForceHistory) -> ForceReading:
    """Say its value [N] along z."""
    return _with_z(said, fault.value, fault.value)


def frozen(fault: LastingFault, said: ForceReading, history: ForceHistory) -> ForceReading:
    """Repeat the reading with which the fault began."""
    return fault.memory.setdefault("first", said)


def dead(fault: LastingFault, said: ForceReading, history: ForceHistory) -> ForceReading:
    """Say zeros, and an error."""
    return ForceReading(np.zeros(6), np.zeros(6), SENSOR_GONE)


def no_number(fault: LastingFault, said: ForceReading, history: ForceHistory) -> ForceReading:
    """Say NaN."""
    return said._replace(raw=np.full(6, np.nan), zero=np.full(6, np.nan))


def _raised(said: ForceReading, force: float) -> ForceReading:
    return _with_z(said, said.raw[2] + force, said.zero[2] + force)


def _with_z(said: ForceReading, raw: float, zero: float) -> ForceReading:
    spoilt = said._replace(raw=said.raw.copy(), zero=said.zero.copy())
    spoilt.raw[2], spoilt.zero[2] = raw, zero
    return spoilt
