"""A path that leads into the body: deeper and deeper, or under another region's name."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from bathbot_bringup.evaluation.safety.sweep.sweep_case import REGIONS, SweepCase, near_by, short
from bathbot_bringup.evaluation.safety.trial.stroke_player import PIECE
from bathbot_bringup.evaluation.safety.virtual.person import Sway
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import VirtualCell

_DEPTHS = (0.005, 0.010, 0.020, 0.030, 0.040)  # [m]
_LASTS = 5.0  # [s]


@dataclass(frozen=True, slots=True)
class DeepPath(SweepCase):
    """A path from the skin to one depth."""

    depth: float  # [m] at the end of the path
    says: str  # the region that its segments name
    sweep: ClassVar[str] = "paths"

    @property
    def place(self) -> tuple[str, str]:
        """Such as face or trunk-on-face, and 40, in mm."""
        what = "" if self.says == self.region else f"{short(self.says)}-on-"
        return f"{what}{short(self.region)}", f"{1e3 * self.depth:.0f}"

    def cell(self, seed: int, sways: tuple[Sway, ...]) -> VirtualCell:
        """With an arm that stands near by at first."""
        return near_by(self.region, seed, sways)

    def happen(self, cell: VirtualCell, rng: np.random.Generator) -> float:
        """Come into contact and follow."""
        cell.approach()
        cell.wait(float(rng.uniform(0.2, 0.8)))
        poses = cell.sinking(self.depth)
        cell.follow(poses, float(rng.uniform(0.02, 0.1)), self.says, len(poses) // PIECE)
        return _LASTS


def paths() -> list[SweepCase]:
    """All cases."""
    own = [DeepPath(region, 0.0, depth, region) for region in REGIONS for depth in _DEPTHS]
    return own + [DeepPath("Face_skin", 0.0, depth, "Trunk_skin") for depth in _DEPTHS]
