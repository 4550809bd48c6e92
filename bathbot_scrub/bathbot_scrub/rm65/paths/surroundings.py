"""What the arm must not meet: itself, walls, and the body the camera sees, outside the patch to be washed.

Whole paths are judged before anything moves. A retract path is shortened where the body is behind the arm,
never refused: leaving must always be possible. Who stands nearer than allowed may move, but no nearer.
"""

import threading
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.arm import DrivenArm
from bathbot_scrub.arm.clearance import BodyClearance, Nearest, SweptArm
from bathbot_scrub.arm.errors import CollisionError, NotReadyError
from bathbot_scrub.rm65.arm.walls import walls_from
from bathbot_scrub.rm65.paths.self_collision import ArmModel
from bathbot_scrub.rm65.paths.speed_near_people import SpeedNearPeople
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.rm65.timing.clock import MONOTONIC

Array = NDArray[np.float64]
_OVERLAP = 0.010  # [m] by which capsules of the arm may overlap: each is drawn some 5 mm wide
_CLOSER = 0.002  # [m] that counts as no nearer


class Body(NamedTuple):
    """Points on the body, or on anything else the camera saw."""

    points: Array  # (M, 3) base frame [m]
    stamp: float  # when all of them were known to be there [s]


class Approach(NamedTuple):
    """How near a path comes to some points of the body, and how near it may."""

    distances: Array  # (N,) [m] at its samples, less what the arm strays between them
    least: float  # [m]
    found: Nearest
    points: Array  # (M, 3) [m]


class Surroundings:
    """Judges joint paths. Thread-safe."""

    def __init__(
        self,
        arm: DrivenArm,
        settings: DriverSettings,
        clock: Callable[[], float] = MONOTONIC,
    ) -> None:
        """Know the arm and the walls; the body comes with `see`.

        Args:
            arm: Whose paths they are.
            settings: Walls, margins, and how old a picture of the body may be.
            clock: Gives the time now [s].
        """
        self.margin, self.scrub_margin = settings.body_margin, settings.scrub_margin
        self._max_age, self._clock = settings.body_max_age, clock
        walls = walls_from(settings.walls)
        self._model, self._model_lock = ArmModel(arm, walls), threading.Lock()
        folded = self._model.nearest(np.radians(settings.home_deg)).distance  # free by the user's word
        self._own = min(-_OVERLAP, folded - _CLOSER)
        self._arm, self._clearance = arm, BodyClearance(arm)
        self._near_people = SpeedNearPeople(arm, self._clearance, self.margin)
        self._body: Body | None = None
        self._blind = False  # the newest cloud was empty: nobody knows where the body is

    def see(self, points: ArrayLike, stamp: float) -> None:
        """Take in what the camera sees: points, shape (M, 3), base frame [m], known there at `stamp` [s].

        A cloud without points does not tell that nobody is there: the last one that had any goes on to count.
        """
        points = np.ascontiguousarray(points, dtype=float).reshape(-1, 3)
        points = points[np.isfinite(points).all(axis=1)]
        self._blind = not len(points)
        if not self._blind:
            self._body = Body(points, stamp)

    @property
    def points(self) -> Array:
        """Where the body was seen last, shape (M, 3), base frame [m]; (0, 3) where no cloud ever came."""
        body = self._body
        return np.empty((0, 3)) if body is None else body.points

    def trust(self) -> None:
        """Refuse to go near a person who is not seen, or not any more; where no cloud came, all is as told.

        Raises:
            NotReadyError: With the reason.
        """
        if self._blind:
            raise NotReadyError(
                "the body cloud is empty: the camera sees nothing within the arm's reach, so nobody knows "
                "where the person is; is its lens free?"
            )
        body = self._body
        if body is not None and (age := self._clock() - body.stamp) > self._max_age:
            raise NotReadyError(
                f"the body was last seen {age:.1f} s ago, too old for a way to the person: the most is "
                f"{self._max_age} s; is target_localizer up, and the camera's lens free?"
            )

    def status(self) -> str:
        """What paths are checked against, for a person."""
        body = self._body
        if body is None and not self._blind:
            return "no body cloud: paths are checked against the arm itself and walls only"
        try:
            self.trust()
        except NotReadyError as error:
            return str(error)
        return f"{len(body.points)} points, {self._clock() - body.stamp:.1f} s old"

    def check(self, joints: ArrayLike, patch: ArrayLike, margin: float) -> None:
        """Refuse a joint path, shape (N, 6) [rad], closely spaced, on which something would be met.

        Args:
            joints: From where the arm stands.
            patch: Places, shape (K, 3) [m], about which the scrub head may touch the body.
            margin: Between links and body [m].

        Raises:
            CollisionError: With the link, what it would meet, where, and how near.
        """
        self._check_itself(self.check_body(joints, patch, margin))

    def check_body(self, joints: ArrayLike, patch: ArrayLike, margin: float) -> SweptArm:
        """The same with regard to the body alone; never waits for another thread. Gives where the arm was."""
        path = self._clearance.swept(np.asarray(joints, dtype=float))
        for met in self._approaches(path, patch, margin):
            worst = int(np.argmin(met.distances))
            if met.distances[worst] < met.least:
                place = "the body at ({:.3f}, {:.3f}, {:.3f}) m".format(*met.points[met.found.points[worst]])
                link = self._clearance.capsules[met.found.links[worst]].link
                raise CollisionError(link, place, float(met.distances[worst]), margin)
        return path

    def free_part(self, joints: ArrayLike, patch: ArrayLike, margin: float) -> int:
        """How many joints of a path, from the first on, lie before anything would be met; as `check_body`."""
        path = self._clearance.swept(np.asarray(joints, dtype=float))
        free = len(path.joints)
        for met in self._approaches(path, patch, margin):
            free = min([free, *np.flatnonzero(met.distances < met.least)[:1]])
        return int(path.places[free - 1]) + 1 if free else 0

    @property
    def body(self) -> Body | None:
        """What was seen last; None before anything was."""
        return self._body

    def heads(self, joints: Array) -> Array:
        """Places of the head's tip, shape (N, 3) [m], at joints (N, 6) [rad]."""
        return self._arm.head(joints)[:, :3, 3]

    def caps(self, lengths: Array, joints: Array) -> Array:
        """Largest ds/dt that people near by allow along a path; see `SpeedNearPeople.caps`."""
        body = self._body
        unknown = self._blind or body is None or self._clock() - body.stamp > self._max_age
        return self._near_people.caps(lengths, joints, None if unknown else body.points)

    def _check_itself(self, path: SweptArm) -> None:
        with self._model_lock:
            near = [self._model.nearest(joints) for joints in path.joints]
        distances = np.array([pair.distance for pair in near])
        worst = int(np.argmin(distances))
        if distances[worst] < min(self._own, distances[0] - _CLOSER):
            first, second, distance = near[worst]
            raise CollisionError(first, second, distance, 0.0)

    def _approaches(self, path: SweptArm, patch: ArrayLike, margin: float) -> Iterator[Approach]:
        """How near a path comes to the body, of whatever age: where somebody was seen last is the best guess.

        The margin is kept to all points but those that the arm stands beside: to these, what there is.
        """
        body = self._body
        if body is None:
            return
        patch = np.reshape(np.asarray(patch, dtype=float), (-1, 3))
        about = margin + float(path.stray[0])  # nearer than that no way could begin
        beside = self._clearance.beside(path.ends[0], body.points, patch, about)
        yield self._approach(path, body.points[~beside], patch, margin)
        if beside.any():
            points = body.points[beside]
            there = self._clearance.nearest(path.ends[:1], points, patch, about).clearances[0]
            least = min(there - _CLOSER, margin)
            yield self._approach(path._replace(stray=0.0 * path.stray), points, patch, least)

    def _approach(self, path: SweptArm, points: Array, patch: Array, least: float) -> Approach:
        interest = least + 2.0 * float(path.stray.max()) + _CLOSER
        found = self._clearance.nearest(path.ends, points, patch, interest)
        return Approach(found.clearances - path.stray, least, found, points)
