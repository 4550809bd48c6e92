"""Runs along a joint path in time: jerk-limited in the length s, able to brake and go on anywhere."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from ruckig import ControlInterface, InputParameter, OutputParameter, Ruckig, RuckigError

from bathbot_scrub.arm.errors import ArmError
from bathbot_scrub.rm65.paths.joint_path import JointPath

Array = NDArray[np.float64]
_HAIR = 1.0 - 1e-6
_CREEP = 1e-4  # least speed [s-units/s] that counts as motion


@dataclass(frozen=True, slots=True)
class Pace:
    """How fast s may change: m, or rad for joint moves, per s, s^2, s^3."""

    speed: float
    acceleration: float
    jerk: float


class PathRunner:
    """Position on a path after each period. Not thread-safe: one thread steps it."""

    def __init__(self, path: JointPath, pace: Pace, period: float) -> None:
        """Stand at the start of `path`, at rest; `period` [s] is the time of one step."""
        self.path, self.pace, self.period = path, pace, period
        self.length, self.speed, self._acceleration = 0.0, 0.0, 0.0
        self.share = 1.0  # of the speed that the path allows, 0..1
        self._braking = False
        self._ruckig = Ruckig(1, period)
        self._input, self._output = InputParameter(1), OutputParameter(1)

    @property
    def at_rest(self) -> bool:
        """Whether s does not change."""
        return abs(self.speed) < _CREEP and abs(self._acceleration) < 1e-2

    @property
    def at_end(self) -> bool:
        """Whether the end is reached, at rest."""
        return self.at_rest and self.path.end - self.length < 1e-6

    @property
    def stands(self) -> bool:
        """Whether it is at rest and stays so: an edge may be passed so slowly that s hardly changes."""
        return self.at_rest and (self._braking or self.at_end)

    def brake(self, pace: Pace | None = None) -> None:
        """Come to rest as soon as acceleration and jerk (of `pace`, if given) allow, and stay there."""
        self._braking = True
        self.pace = pace or self.pace

    def go_on(self, pace: Pace | None = None) -> None:
        """Go on along the path after a brake."""
        self._braking = False
        self.pace = pace or self.pace

    def begin_anew(self) -> None:
        """The arm has come to rest here by itself: whatever follows begins from rest."""
        self.speed = self._acceleration = 0.0

    def replace(self, path: JointPath) -> None:
        """Run on a longer path that has the same samples up to here."""
        self.path = path

    def rebase(self, path: JointPath, cut: float) -> None:
        """Run on another path that is the same here, but whose lengths are less by `cut`."""
        self.path, self.length = path, self.length - cut

    def step(self) -> Array:
        """Advance by one period; give the joints [rad], shape (6,).

        Raises:
            ArmError: When no jerk-limited motion exists; does not happen with finite limits.
        """
        if self.stands:
            self.speed = self._acceleration = 0.0
            return self.path.at(self.length)
        given = self._input
        given.current_position, given.current_velocity = [self.length], [self.speed]
        given.current_acceleration = [self._acceleration]
        given.max_acceleration, given.max_jerk = [self.pace.acceleration], [self.pace.jerk]
        given.target_velocity, given.target_acceleration = [0.0], [0.0]
        if self._braking:
            given.control_interface = ControlInterface.Velocity
        else:
            # the time that it takes to turn the acceleration now into braking
            reaction = (self._acceleration + self.pace.acceleration) / self.pace.jerk
            ahead = max(reaction * self.speed, 0.0)  # at rest the speed may be a hair below zero
            allowed = self.share * min(self.pace.speed, self.path.speed_at(self.length, ahead))
            given.control_interface = ControlInterface.Position
            given.target_position = [self.path.end]
            given.max_velocity = [max(allowed, 10 * _CREEP)]
        self._update()
        self.length = self._output.new_position[0]
        self.speed, self._acceleration = self._output.new_velocity[0], self._output.new_acceleration[0]
        return self.path.at(self.length)

    def _update(self) -> None:
        """Step, with a jerk a hair less where two kinds of profile meet and Ruckig finds neither."""
        try:
            self._ruckig.update(self._input, self._output)
        except RuckigError:
            self._input.max_jerk = [_HAIR * self.pace.jerk]
            try:
                self._ruckig.update(self._input, self._output)
            except RuckigError as error:
                raise ArmError(
                    f"no motion from s={self.length:.4f}, v={self.speed:.4f} to {self.path.end:.4f}"
                ) from error
