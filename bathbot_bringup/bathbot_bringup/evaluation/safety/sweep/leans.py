"""The person leans into the way of an arm that has planned it already."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from bathbot_bringup.evaluation.safety.sweep.sweep_case import REGIONS, SweepCase, short
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import VirtualCell

_DISTANCES = (0.04, 0.08, 0.12, 0.16, 0.20)  # [m]
_SPEEDS = (0.0, 0.05, 0.1, 0.2, 0.3)  # [m/s]; 0: the person is there before the arm sets out
_AT_ONCE = 100.0  # [m/s]
_NEAR = 0.05  # [m] from the skin: between there and where the head begins it is when the person does
_EVERY, _LATE = 0.2, 0.2  # [s] between clouds of a camera that sees, and of each behind its picture


@dataclass(frozen=True, slots=True)
class LeanIn(SweepCase):
    """One distance, at one speed; seen by a camera or not."""

    far: float  # [m]
    seen: bool
    sweep: ClassVar[str] = "leans"

    @property
    def place(self) -> tuple[str, str]:
        """Such as blind-face-120 and 200, in mm and mm/s; there: before the arm sets out."""
        how = f"{1e3 * self.body_speed:.0f}" if self.body_speed else "there"
        return f"{'seen' if self.seen else 'blind'}-{short(self.region)}-{1e3 * self.far:.0f}", how

    def happen(self, cell: VirtualCell, rng: np.random.Generator) -> float:
        """Approach; once the way is planned the person leans."""
        if self.seen:
            cell.look(_EVERY, _LATE)
            cell.wait(_LATE + _EVERY * float(rng.uniform(0.1, 1.0)))
        if self.body_speed:
            gap = float(rng.uniform(_NEAR, cell.gap()))
            cell.when(lambda: cell.gap() <= gap, lambda: cell.lean(self.far, self.body_speed))
        else:
            cell.lean(self.far, _AT_ONCE)
        cell.approach()
        return 1.0


def leans() -> list[SweepCase]:
    """All cases."""
    return [
        LeanIn(region, speed, far, seen)
        for seen in (False, True)
        for region in REGIONS
        for far in _DISTANCES
        for speed in _SPEEDS
    ]
