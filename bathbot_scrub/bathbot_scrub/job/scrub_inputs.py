"""Everything that a scrub path is planned from, kept as it comes: skin, target, head, joints, body."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.errors import NotReadyError
from bathbot_scrub.job.before_contact import BeforeContact
from bathbot_scrub.path.planner import Task
from bathbot_scrub.path.surface_map import Sighting
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

Array = NDArray[np.float64]
_PATH_IDS = 2**32  # of a uint32


class ScrubInputs:
    """Keeps what was seen last; what takes time to decode is decoded when a path is asked for."""

    def __init__(self, settings: ScrubPlannerSettings) -> None:
        """Begin without anything seen."""
        self.before = BeforeContact(settings.surface_max_age, settings.breath_window)
        self._body_max_age = settings.body_max_age
        self._head: Callable[[], Array] | None = None
        self._joints: Callable[[], Array] | None = None
        self._body: Sighting | None = None

    @property
    def knows_arm(self) -> bool:
        """Whether head and joints were ever told."""
        return self._head is not None and self._joints is not None

    @property
    def knows_body(self) -> bool:
        """Whether the body was ever seen."""
        return self._body is not None

    def see_head(self, decode: Callable[[], Array]) -> None:
        """Take in where the head is: `decode` gives T_base_head, shape (4, 4)."""
        self._head = decode

    def see_joints(self, decode: Callable[[], Array]) -> None:
        """Take in how the arm stands: `decode` gives joint angles [rad], shape (6,)."""
        self._joints = decode

    def see_body(self, sighting: Sighting) -> None:
        """Take in what the camera sees of the body."""
        self._body = sighting

    def task(self, region: str, max_length: float, now: float) -> Task:
        """What a path is planned from that is asked for at time `now` [s]; its id counts milliseconds.

        Raises:
            NotReadyError: The arm is not in contact or its posture is not known.
            SurfaceError: No recent surface or target of the region.
        """
        sighting, target = self.before.recall(region, now)
        if self._head is None or self._joints is None:
            raise NotReadyError("no tool_pose or joint_states yet; is rm65_driver running?")
        head, joints, recent = self._head(), self._joints(), self.before.recent
        path_id = int(1e3 * now) % _PATH_IDS
        return Task(
            sighting.decode(), sighting.stamp, target, head, joints, max_length, recent, path_id, region
        )

    def body(self, now: float) -> ArrayLike:
        """Points that links must keep off at time `now` [s], shape (N, 3) [m]; none where no cloud ever came.

        Raises:
            NotReadyError: They were seen too long ago, or there are none in the newest cloud.
        """
        if self._body is None:
            return ()
        age = now - self._body.stamp
        if age > self._body_max_age:
            raise NotReadyError(
                f"the body was last seen {age:.1f} s ago, allowed are {self._body_max_age} s "
                "(body_max_age); is target_localizer up, and the camera's lens free?"
            )
        points = np.reshape(self._body.decode(), (-1, 3))
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            raise NotReadyError(
                "the body cloud is empty: the camera sees nothing within the arm's reach, so nobody knows "
                "where the person is; is its lens free?"
            )
        return points
