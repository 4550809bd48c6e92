"""What was seen of the skin before the arm came in front of it."""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.states import State
from bathbot_scrub.errors import NotReadyError, SurfaceError
from bathbot_scrub.job.scrub_job import ArmReport
from bathbot_scrub.path.surface_map import Sighting

Array = NDArray[np.float64]


class SeenTarget(NamedTuple):
    """A contact target, T_base_target of shape (4, 4), and its time [s]."""

    stamp: float
    T_base_target: Array


_SPARSE = 0.18  # between surfaces kept of the last breaths [s]


class BeforeContact:
    """Keeps the last surface and the last target of each region from the time the arm was free.

    Topics overtake each other: what was seen counts once the arm has said again that it is free. And,
    whatever the arm did, some surfaces of the last seconds: they tell how the person breathes.
    """

    def __init__(self, max_age: float, breath_window: float) -> None:
        """Remember for `max_age` [s], and surfaces of the last `breath_window` [s]."""
        self._max_age, self._breath_window = max_age, breath_window
        self._recent: deque[Sighting] = deque()
        self._surface: Sighting | None = None
        self._fresh_surface: Sighting | None = None
        self._targets: dict[str, SeenTarget] = {}
        self._fresh_targets: dict[str, SeenTarget] = {}
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
        if self._free and report.state == State.FREE:
            self._surface = self._fresh_surface or self._surface
            self._targets |= self._fresh_targets
        if report.state != State.FREE:
            self._fresh_surface, self._fresh_targets = None, {}
        self._report = report

    def see_targets(self, targets: dict[str, Array], stamp: float) -> None:
        """Take in contact targets, region -> T_base_target, of time `stamp` [s], if the arm is free."""
        if self._free:
            self._fresh_targets |= {region: SeenTarget(stamp, pose) for region, pose in targets.items()}

    def see_surface(self, sighting: Sighting) -> None:
        """Take in a surface; it counts as unhidden if the arm is free."""
        if self._free:
            self._fresh_surface = sighting
        if not self._recent or sighting.stamp - self._recent[-1].stamp >= _SPARSE:
            self._recent.append(sighting)
        while self._recent[0].stamp < sighting.stamp - self._breath_window:
            self._recent.popleft()

    @property
    def recent(self) -> tuple[Sighting, ...]:
        """Surfaces of the last breaths, the oldest first."""
        return tuple(self._recent)

    def recall(self, region: str, now: float) -> tuple[Sighting, Array]:
        """The surface and the target, shape (4, 4), to plan on at time `now` [s].

        Raises:
            NotReadyError: The arm is not in contact.
            SurfaceError: There is none, or it is too old.
        """
        if self.arm.state != State.CONTACT:
            raise NotReadyError(
                f"the arm is in {self.arm.state.name}, not in CONTACT; "
                "send it to the target by action approach first"
            )
        if region not in self._targets:
            raise SurfaceError(
                f"no contact target of region {region!r} was seen while the arm was free, "
                f"seen were {', '.join(self._targets) or 'none'}; retract, home and look again"
            )
        if self._surface is None:
            raise SurfaceError("no surface was seen while the arm was free; is target_localizer active?")
        target = self._targets[region]
        for what, stamp in (("surface", self._surface.stamp), ("contact target", target.stamp)):
            if now - stamp > self._max_age:
                raise SurfaceError(
                    f"the {what} seen while the arm was free is {now - stamp:.0f} s old, allowed are "
                    f"{self._max_age:.0f} s (surface_max_age); retract, home and look again"
                )
        return self._surface, target.T_base_target

    @property
    def _free(self) -> bool:
        return self._report is not None and self._report.state == State.FREE
