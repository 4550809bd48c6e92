"""One case of a sweep: what is done to the arm, how fast the body moves, and how hard it may be met."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from bathbot_scrub.arm.errors import ArmError
from bathbot_scrub.arm.force_limits import shipped_force_limits

from bathbot_bringup.evaluation.safety.virtual.person import Sway
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import VirtualCell, ready_deg

REGIONS = ("Face_skin", "Hand_skin", "Trunk_skin")
SLOW = 0.1  # [m/s] up to which a body must not be met much harder than the threshold at which the arm leaves
_MORE = 1.2  # times that threshold
_BREATH = 0.002, 0.25  # [m], [Hz] of every other person
_WATCH = 1.0  # [s] after all is over
_READY, _STANDOFF = 0.05, 0.025  # [m] before the skin: home and stand-off of an arm that stands near by


class Outcome(NamedTuple):
    """One trial as it stands in the JSON file."""

    case: str
    row: str
    column: str
    seed: int
    peak_n: float  # largest true contact force of the whole trial
    bound_n: float
    state: str  # of the driver at the end
    said: str  # by the driver at the end; or why it refused


@dataclass(frozen=True, slots=True)
class SweepCase(ABC):
    """A case; a seed makes it a trial.

    Attributes:
        region: Class of the skin.
        body_speed: Of the body [m/s]; 0: it does not move while the arm does.
    """

    region: str
    body_speed: float
    sweep: ClassVar[str]

    @property
    @abstractmethod
    def place(self) -> tuple[str, str]:
        """Row and column of the table, in words without spaces."""

    @property
    def name(self) -> str:
        """By which it can be asked for: row and column."""
        return "-".join(self.place)

    @abstractmethod
    def happen(self, cell: VirtualCell, rng: np.random.Generator) -> float:
        """Let it happen in a cell; give the time [s] to watch on.

        Raises:
            ArmError: When the driver refuses, or gives up.
        """

    def cell(self, seed: int, sways: tuple[Sway, ...]) -> VirtualCell:
        """The cell it happens in."""
        return VirtualCell(self.region, seed, sways)

    @property
    def bound(self) -> float:
        """Largest force [N] with which the body may be met."""
        limits = shipped_force_limits().region(self.region)
        return min(_MORE * limits.retract, limits.hard_stop) if self.body_speed <= SLOW else limits.hard_stop

    def run(self, seed: int) -> Outcome:
        """Run one trial; every other person breathes."""
        rng = np.random.default_rng([seed, *self.name.encode()])
        phase = float(rng.uniform(0.0, 2.0 * np.pi))
        cell = self.cell(seed, (Sway(*_BREATH, phase),) if seed % 2 else ())
        said, watch = "", 0.0
        try:
            watch = self.happen(cell, rng)
        except ArmError as error:
            said = str(error)
        cell.wait(watch + _WATCH)
        end = cell.driver.snapshot()
        return Outcome(
            self.name, *self.place, seed, cell.peak(), self.bound, end.state.name, said or end.reason
        )


def near_by(region: str, seed: int, sways: tuple[Sway, ...]) -> VirtualCell:
    """A cell whose arm stands near by at first, to save time where the way there does not matter."""
    return VirtualCell(region, seed, sways, home_deg=ready_deg(_READY), standoff=_STANDOFF)


def short(region: str) -> str:
    """A region as it stands in names: face for Face_skin."""
    return region.removesuffix("_skin").lower()
