"""What was seen of the skin before the arm came in front of it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.errors import NotReadyError, SurfaceError
from bathbot_scrub.scrub_job import ArmMode, ArmReport, Sighting

Array = NDArray[np.float64]


class SeenTarget(NamedTuple):
    """A contact target, T_base_target of shape (4, 4), and its time [s]."""

    stamp: float
    T_base_target: Array


class BeforeContact:
    """Keeps the last surface and the last target of each region from the time the arm was free."""

    def __init__(self, max_age: float) -> None:
        """Remember for `max_age` [s]."""
        self._max_age = max_age
        self._surface: Sighting | None = None
        self._targets: dict[str, SeenTarget] = {}
        self._report: ArmReport | None = None

    @property
    def arm(self) -> ArmReport:
        """What the arm said last.

        Raises:
            NotReadyError: When it has not said anything yet.
        """
        if self._report is None:
            raise NotReadyError("no arm_state yet; is rm65_driver running?")
        return self._report

    def see_arm(self, report: ArmReport) -> None:
        """Take in what the arm says."""
        self._report = report

    def see_targets(self, targets: dict[str, Array], stamp: float) -> None:
        """Take in contact targets, region -> T_base_target, of time `stamp` [s], if the arm is free."""
        if self._free:
            self._targets.update({region: SeenTarget(stamp, pose) for region, pose in targets.items()})

    def see_surface(self, sighting: Sighting) -> None:
        """Take in a surface, if the arm is free."""
        if self._free:
            self._surface = sighting

    def recall(self, region: str, now: float) -> tuple[Sighting, Array]:
        """The surface and the target, shape (4, 4), to plan on at time `now` [s].

        Raises:
            NotReadyError: The arm is not in contact.
            SurfaceError: There is none, or it is too old.
        """
        if self.arm.mode != ArmMode.CONTACT:
            raise NotReadyError(
                f"the arm is in {self.arm.mode.name}, not in CONTACT; send it to the target by action approach first"
            )
        if region not in self._targets:
            raise SurfaceError(
                f"no contact target of region {region!r} was seen while the arm was free, "
                f"seen were {', '.join(self._targets) or 'none'}; retract, home and look again"
            )
        if self._surface is None:
            raise SurfaceError("no surface was seen while the arm was free; is target_localizer active?")
        for what, stamp in (("surface", self._surface.stamp), ("contact target", self._targets[region].stamp)):
            if now - stamp > self._max_age:
                raise SurfaceError(
                    f"the {what} seen while the arm was free is {now - stamp:.0f} s old, allowed are "
                    f"{self._max_age:.0f} s (surface_max_age); retract, home and look again"
                )
        return self._surface, self._targets[region].T_base_target

    @property
    def _free(self) -> bool:
        return self._report is not None and self._report.mode == ArmMode.FREE
