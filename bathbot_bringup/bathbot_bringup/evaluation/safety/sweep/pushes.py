"""The body comes against the brush, at any speed, while that rests on it or scrubs it."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from bathbot_bringup.evaluation.safety.sweep.sweep_case import REGIONS, SweepCase, near_by, short
from bathbot_bringup.evaluation.safety.virtual.person import Sway
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import VirtualCell

_SPEEDS = (0.005, 0.010, 0.020, 0.030, 0.040, 0.060, 0.100, 0.150, 0.200)  # [m/s]
_FAR = 0.06  # [m] by which the body comes


@dataclass(frozen=True, slots=True)
class Push(SweepCase):
    """One speed."""

    scrubbing: bool
    sweep: ClassVar[str] = "pushes"

    @property
    def place(self) -> tuple[str, str]:
        """Such as rest-face and 20, in mm/s."""
        phase = "scrub" if self.scrubbing else "rest"
        return f"{phase}-{short(self.region)}", f"{1e3 * self.body_speed:.0f}"

    def cell(self, seed: int, sways: tuple[Sway, ...]) -> VirtualCell:
        """With an arm that stands near by at first."""
        return near_by(self.region, seed, sways)

    def happen(self, cell: VirtualCell, rng: np.random.Generator) -> float:
        """Come into contact, scrub if need be, and be pushed."""
        cell.approach()
        cell.wait(float(rng.uniform(0.2, 0.8)))
        if self.scrubbing:
            cell.scrub(depth=float(rng.uniform(0.0035, 0.006)), speed=float(rng.uniform(0.03, 0.07)))
            cell.wait(float(rng.uniform(0.4, 1.4)))
        cell.lean(_FAR, self.body_speed)
        return _FAR / self.body_speed


def pushes() -> list[SweepCase]:
    """All cases."""
    return [
        Push(region, speed, scrubbing)
        for scrubbing in (False, True)
        for region in REGIONS
        for speed in _SPEEDS
    ]
