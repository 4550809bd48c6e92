"""Planned motions one after the other: connected pieces, pause, stop, deletion, and their ends."""

from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from bathbot_scrub.arm.errors import ArmError
from bathbot_scrub.rm65.paths.path_runner import Pace, PathRunner
from numpy.typing import NDArray

from bathbot_bringup.sim.arm.controller.motion_plan import Plan

Array = NDArray[np.float64]
Ending = Callable[[bool], dict[str, Any] | None]


class Settled(NamedTuple):
    """A planned motion has ended, and what clients are told."""

    reached: bool  # whether it came to its goal
    frame: dict[str, Any] | None  # None: nothing


def completion(reached: bool) -> dict[str, Any]:
    """The event that tells clients that a planned motion has ended."""
    return {
        "state": "current_trajectory_state",
        "trajectory_state": reached,
        "device": 0,
        "trajectory_connect": 0,
    }


def silent(reached: bool) -> None:
    """End without an event, as teaching does."""


class MotionQueue:
    """Runs plans piece by piece; one event for all of them, at the end."""

    def __init__(self, period: float) -> None:
        """Begin empty; `period` [s] is the time of one step."""
        self._period = period
        self._waiting: list[Plan] = []  # connected pieces whose last one is still to come
        self._pieces: deque[Plan] = deque()
        self._runner: PathRunner | None = None
        self._ending: Ending = completion
        self._stopping = False
        self.paused = False

    @property
    def busy(self) -> bool:
        """Whether a motion is on its way, pauses included."""
        return self._runner is not None

    @property
    def current(self) -> Plan | None:
        """The piece that runs."""
        return self._pieces[0] if self._pieces else None

    @property
    def waiting(self) -> list[Plan]:
        """Pieces that wait for the last one."""
        return list(self._waiting)

    def take_back(self) -> Plan:
        """Take the newest piece that waits out again."""
        return self._waiting.pop()

    def add(self, plan: Plan, more: bool, ending: Ending = completion) -> None:
        """Take a piece; it begins at once, or with the one after it when `more` follow."""
        self._waiting.append(plan)
        if more:
            return
        self._pieces, self._waiting = deque(self._waiting), []
        self._ending, self._stopping, self.paused = ending, False, False
        self._start()

    def _start(self) -> None:
        plan = self._pieces[0]
        self._runner = PathRunner(plan.path, plan.pace, self._period)

    def stop(self, slow: bool) -> None:
        """Brake on the path; the motion is given up."""
        self._waiting.clear()
        if self._runner is not None:
            self._stopping, pace = True, self._runner.pace
            self._runner.brake(Pace(pace.speed, (1.0 if slow else 2.0) * pace.acceleration, 4.0 * pace.jerk))

    def pause(self) -> None:
        """Brake on the path and wait there."""
        if self._runner is not None and not self._stopping and not self.paused:
            self.paused = True
            self._runner.brake()

    def go_on(self) -> None:
        """Go on after a pause."""
        if self._runner is not None and self.paused:
            self.paused = False
            self._runner.go_on()

    def delete(self) -> None:
        """Give up the motion in which the arm pauses, with all its pieces."""
        self._stopping = True

    def abandon(self) -> list[Settled]:
        """Give up everything at once."""
        self._waiting.clear()
        return self._end(False) if self.busy else []

    def step(self, at_rest: bool) -> tuple[Array | None, list[Settled]]:
        """Advance by one period.

        Args:
            at_rest: Whether the joints stand where they were told to.

        Returns:
            Joints to go to [rad], None when no motion runs or none is possible, and what has ended.
        """
        if self._runner is None:
            return None, []
        try:
            joints = self._runner.step()
        except ArmError:
            return None, self._end(False)
        if not at_rest or not self._runner.at_rest:
            return joints, []
        if self._stopping:
            return joints, self._end(False)
        if self._runner.at_end and not self.paused:
            if len(self._pieces) == 1:
                return joints, self._end(True)
            self._pieces.popleft()
            self._start()
        return joints, []

    def _end(self, reached: bool) -> list[Settled]:
        self._runner, self._stopping, self.paused = None, False, False
        self._pieces.clear()
        return [Settled(reached, self._ending(reached))]
