"""The path off the skin, planned before it is needed.

A straight line along the outward normal takes a few milliseconds to plan; it is planned in the pauses of
the control loop, while the head touches. A head that has moved on meanwhile by a few millimetres takes the
line that is ready, shifted to where it is. It ends before anything the camera saw behind the arm - a knee,
a hand - but takes the head off the skin in any case.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.rm65.paths.joint_path import JointPath
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner
from bathbot_scrub.rm65.paths.path_runner import Pace
from bathbot_scrub.rm65.timing.clock import MONOTONIC

Array = NDArray[np.float64]
_SHORTEST = 0.02  # [m]
_AGAIN, _FARTHEST = 0.025, 0.05  # [rad] from where a line was planned: plan anew; do not use it
_OLDEST = 1.0  # [s]: the camera tells as often what is behind the arm
_RETRY = 0.05  # [s] until a line is looked for again where there was none: that takes the loop's time
_DECELERATION = 1.0  # [m/s^2] at the end of the way, where haste is over
_ARRIVAL = 0.05  # [m/s] from which any brake is gentle


class Retract(NamedTuple):
    """How the arm leaves the skin."""

    distance: float  # [m]
    speed: float  # [m/s]
    # the command reaches its speed within one period: the joints, not the command, limit what follows
    acceleration: float = 25.0  # [m/s^2]
    jerk: float = 1e4  # [m/s^3]

    @property
    def pace(self) -> Pace:
        """As the pace of a motion."""
        return Pace(self.speed, self.acceleration, self.jerk)


class RetractPath:
    """Keeps one line ready."""

    def __init__(
        self, planner: MotionPlanner, retract: Retract, clock: Callable[[], float] = MONOTONIC
    ) -> None:
        """Plan with `planner`, as `retract` says; `clock` gives the time now [s]."""
        self._planner, self._retract, self._clock = planner, retract, clock
        self._ready: JointPath | None = None
        self._planned = -np.inf  # [s]

    @property
    def arm(self) -> Arm:
        """Whose way it is."""
        return self._planner.arm

    @property
    def pace(self) -> Pace:
        """At which to leave."""
        return self._retract.pace

    def prepare(self, joints: Array) -> None:
        """Plan the way from joints [rad], shape (6,), unless one from nearby was planned a moment ago."""
        now = self._clock()
        if self._due(joints, now - self._planned):
            self._planned = now
            try:
                self._ready = self._plan(joints)
            except UnreachableError:
                self._ready = None  # said when it is asked for

    def _due(self, joints: Array, age: float) -> bool:
        """Tell whether to plan from joints [rad], shape (6,), `age` [s] after the last time."""
        if self._ready is None:
            return age > _RETRY
        return age > _OLDEST or bool(np.abs(joints - self._ready.joints[0]).max() > _AGAIN)

    def path(self, joints: Array) -> JointPath:
        """The way from joints [rad], shape (6,).

        Raises:
            UnreachableError: When there is no way straight back.
        """
        ready = self._ready
        if ready is not None:
            shift = joints - ready.joints[0]
            moved = replace(ready, joints=ready.joints + shift)
            if np.abs(shift).max() <= _FARTHEST and self._planner.limits.contain(moved.joints).all():
                return moved
        return self._plan(joints)

    def demand_free(self, path: JointPath) -> None:
        """Refuse a way on which something known would be met; for ways beyond where the arm came from.

        Raises:
            CollisionError: With what is in the way.
        """
        self._planner.check(path.joints, self._place(path))

    def _plan(self, joints: Array) -> JointPath:
        line = self._planner.line(joints, -self._retract.distance, self._retract.speed, _SHORTEST)
        line = self._free_part(line)
        slowing = np.sqrt(2.0 * _DECELERATION * (line.end - line.lengths) + _ARRIVAL**2)
        return replace(line, speed_limit=np.minimum(line.speed_limit, slowing))

    def _free_part(self, line: JointPath) -> JointPath:
        """As much of a line as meets no body, and the shortest way off the skin whatever is there."""
        free = self._planner.free_part(line.joints, self._place(line))
        return line.until(max(line.lengths[max(free - 1, 0)], _SHORTEST))

    def _place(self, path: JointPath) -> Array:
        """Where the head is at first, shape (1, 3) [m]: there it may touch."""
        return self._planner.arm.head(path.joints[0])[None, :3, 3]
