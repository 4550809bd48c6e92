"""The emulated six-axis force sensor at the flange: weight, bias, noise, zeroing."""

from collections import deque

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD, ScrubHead
from numpy.typing import NDArray

from bathbot_bringup.sim.faults.fault_schedule import FaultSchedule
from bathbot_bringup.sim.faults.force_faults import ForceHistory, ForceReading
from bathbot_bringup.sim.faults.lasting_fault import Place

Array = NDArray[np.float64]
_BIAS = np.array([1.2, -0.8, 2.0, 0.02, -0.03, 0.01])  # [N, Nm] of the strain gauges
_DRIFT = np.array([0.3, -0.2, 0.25, 0.0, 0.0, 0.0])  # [N, Nm] since the last calibration; zeroing removes it
_NOISE = np.array([0.05] * 3 + [0.002] * 3)  # [N, Nm] standard deviation
_CALIBRATED = 0.98  # share of the weight that the calibration knows
_GRAVITY = np.array([0.0, 0.0, -9.80665])  # [m/s^2] in the base frame
_AVERAGED = 20  # samples that zeroing averages, 0.1 s


class ForceSensor:
    """Turns the true contact force into what the controller would report."""

    def __init__(
        self, rng: np.random.Generator, faults: FaultSchedule | None = None, period: float = 0.005,
        head: ScrubHead = SCRUB_HEAD,
    ) -> None:  # fmt: skip
        """Start uncleared; `rng` makes the noise, `faults` spoil the readings, `period` [s] apart."""
        self._rng, self._head = rng, head
        self._faults, self._history = faults or FaultSchedule(), ForceHistory(period)
        self._offset, self._drift = np.zeros(6), _DRIFT
        self._share = _CALIBRATED  # of the weight that the controller knows
        self._recent: deque[Array] = deque(maxlen=_AVERAGED)
        self.reading = ForceReading(np.zeros(6), np.zeros(6))

    def measure(self, T_base_flange: Array, force: Array, torque: Array) -> ForceReading:
        """Read the sensor under a force [N] and a torque [Nm] about the tip, (3,) each, in the base frame."""
        to_sensor = T_base_flange[:3, :3].T
        weight = to_sensor @ (self._head.mass * _GRAVITY)
        carried = _with_arm(weight, self._head.mass_centre)
        external = _with_arm(to_sensor @ force, self._head.length)
        external[3:] += to_sensor @ torque
        raw = external + carried + _BIAS + self._drift + _NOISE * self._rng.standard_normal(6)
        compensated = raw - _BIAS - self._share * carried
        said = self._say(ForceReading(raw, compensated))
        self._recent.append(said.zero)
        self.reading = said._replace(zero=said.zero - self._offset)
        return self.reading

    def _say(self, true: ForceReading) -> ForceReading:
        """What a true reading becomes while faults last."""
        self._history.keep(true)
        said = true
        for fault in self._faults.at(Place.FORCE_SENSOR):
            said = fault(said, self._history)
        return said

    def calibrate(self) -> None:
        """Learn weight and drift anew, as the procedure with four postures does; zeroing is forgotten."""
        self._share, self._drift, self._offset = 1.0, np.zeros(6), np.zeros(6)
        self._recent.clear()

    def clear(self) -> None:
        """Zero at the present posture, from the samples of the last 0.1 s; in vain if they are no numbers."""
        if self._recent and np.isfinite(self._recent).all():
            self._offset = np.mean(self._recent, axis=0)


def _with_arm(force: Array, distance: float) -> Array:
    """Wrench [N, Nm], shape (6,), about the flange of a force (3,) on its z axis at a distance [m]."""
    x, y, z = force
    return np.array([x, y, z, -distance * y, distance * x, 0.0])
