"""What the brush of the emulated arm meets, asked for as often as the distance demands."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.brush import Brush, Contact, SkinSurface
from bathbot_bringup.sim.faults.fault_schedule import FaultSchedule
from bathbot_bringup.sim.faults.lasting_fault import Place
from bathbot_bringup.sim.faults.pushed_surface import BodyStep, PushedSurface

Array = NDArray[np.float64]
_FAR = 0.05  # [m] of gap above which contact is looked for seldom
_SELDOM = 10  # steps


class SkinContact:
    """Brush and body of one arm."""

    def __init__(
        self,
        brush: Brush,
        surface: SkinSurface,
        clock: Callable[[], float],
        faults: FaultSchedule,
        period: float,
    ) -> None:
        """Touch nothing yet.

        Args:
            brush: What touches.
            surface: What it may touch.
            clock: Time of the body [s].
            faults: Push the body about.
            period: Of a step [s].
        """
        self.surface = PushedSurface(surface)
        self.now = Contact(-2.0 * _FAR, 0.0, np.zeros(3), np.zeros(3), "")
        self._brush, self._clock, self._faults, self._period = brush, clock, faults, period
        self._before: Array | None = None
        self._wait = 0

    def step(self, T_base_head: Array) -> Contact:
        """Advance by one period to a pose of the head, (4, 4)."""
        t = self._clock()
        for fault in self._faults.at(Place.BODY):
            fault(self.surface, BodyStep(T_base_head, t, self.now.compression > 0.0, self._period))
        position = T_base_head[:3, 3]
        velocity = (position - (position if self._before is None else self._before)) / self._period
        self._before = position.copy()
        self._wait -= 1
        if self._wait <= 0:
            self.now = self._brush.touch(T_base_head, velocity, self.surface, t)
            self._wait = _SELDOM if self.now.compression < -_FAR else 1
        return self.now


def collides(stage: int, force: Array) -> bool:
    """Whether a contact force [N], shape (3,), stops the arm at a collision stage, 0 (off) to 8.

    80 N at stage 1 down to 10 N at stage 8: the vendor publishes no numbers, these are ours.
    """
    return stage > 0 and float(np.linalg.norm(force)) > 90.0 - 10.0 * stage
