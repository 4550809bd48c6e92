"""The force guard: what the arm may do next, from force, age of the data and connection. Pure.

States and what leads from one to the next:

    FREE -> APPROACH            asked to approach, or to go home
    APPROACH -> CONTACT         skin felt on the straight part
    APPROACH -> HOLD            nothing felt, or stopped
    any that moves or touches -> RETRACTING   force above a threshold, or asked
    RETRACTING -> FREE          asked, and done
    RETRACTING -> HOLD          forced, and done; FAULT when the hard limit was passed
    any that moves or touches -> FAULT  data too old, connection lost
    FAULT -> RETRACTING         pressed on the skin, by data that can be trusted again
    FAULT -> HOLD               the cause is gone and someone resumes
"""

from enum import Enum, IntEnum

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.errors import NotReadyError
from bathbot_scrub.rm65.force_excess import Reading, limit_passed, surge
from bathbot_scrub.rm65.force_limits import ForceLimits, RegionLimits

Array = NDArray[np.float64]


class State(IntEnum):
    """States as in bathbot_msgs/ArmState."""

    FREE = 0
    APPROACH = 1
    CONTACT = 2
    RETRACTING = 3
    HOLD = 4
    FAULT = 5


class Action(Enum):
    """What the control loop must do at once."""

    GO_ON = "go on"
    STOP = "stop"
    RETRACT = "retract"


class Cause(Enum):
    """Why the guard ended a motion."""

    NONE = "none"
    NO_CONTACT = "no contact"
    FORCE = "force"
    DATA = "data"


class ForceGuard:
    """The state of the arm with regard to the person. Time comes in as the age of readings."""

    def __init__(self, limits: ForceLimits, stale_after: float) -> None:
        """Begin FREE; data older than `stale_after` [s] stops the arm."""
        self._limits, self._stale_after = limits, stale_after
        self.state, self.reason, self.cause = State.FREE, "", Cause.NONE
        self.region: RegionLimits = limits.gentlest()
        self.touching = False  # on the skin, or so near that it may be
        self.moving = False  # set by the control loop
        self._seeking = False
        self._settled = False  # the search has come to rest: a rise of force is the body's doing now
        self._paused_from: State | None = None
        self._after_retract = State.FREE

    @property
    def threshold(self) -> float:
        """Force [N] above which the arm retracts."""
        return self.region.retract

    @property
    def paused(self) -> bool:
        """Whether a motion waits to be resumed."""
        return self._paused_from is not None

    @property
    def contact_force(self) -> float:
        """Force [N] at which skin counts as felt."""
        return self._limits.contact

    def check(self, reading: Reading) -> Action:
        """Judge one reading; changes the state and tells what to do at once."""
        if self.state is State.FAULT:  # still leaves when pressed, as long as the force can be trusted
            excess = self._excess(reading) if self.touching and not self._doubt(reading) else ""
            return self._leave(excess, hard=True) if excess else Action.GO_ON
        if (self.moving or self.touching) and (trouble := self._doubt(reading)):
            return self.fault(trouble)
        if self.state is State.RETRACTING:
            if reading.sudden > self.region.hard_stop and self._after_retract is not State.FAULT:
                self._after_retract = State.FAULT
                self.reason = f"retracting: force {reading.sudden:.1f} N passed the hard limit"
            return Action.GO_ON
        if excess := self._excess(reading):
            return self._leave(excess, reading.sudden > self.region.hard_stop)
        if self._seeking and np.linalg.norm(reading.wrench[:3]) >= self._limits.contact:
            self._seeking = self._settled = False
            self.state, self.reason = State.CONTACT, ""
            return Action.STOP
        self._settled = self._settled or not self.moving
        return Action.GO_ON

    def begin_approach(self, region: RegionLimits, reason: str = "") -> None:
        """Go from FREE or HOLD on the way to a target, through free air.

        Raises:
            NotReadyError: In any other state, or on the skin.
        """
        if self.state not in (State.FREE, State.HOLD):
            raise NotReadyError(
                f"the arm is in state {self.state.name} ({self.reason or 'busy'}); "
                "wait until it is free, or call arm/stop or arm/resume"
            )
        if self.touching:
            raise NotReadyError("the head may be on the skin; call arm/retract first")
        self._enter(State.APPROACH, reason)
        self.region = region

    def begin_seeking(self) -> None:
        """Begin the straight part: from here on the head may touch."""
        if self.state is not State.APPROACH:
            raise NotReadyError(f"the approach ended in state {self.state.name}: {self.reason}")
        self._seeking = self.touching = True
        self._settled = False

    def begin_retract(self) -> None:
        """Leave because someone asked.

        Raises:
            NotReadyError: In FAULT.
        """
        if self.state is State.FAULT:
            raise NotReadyError(f"the arm is in FAULT ({self.reason}); mend it and call arm/resume first")
        if self.state is not State.RETRACTING:
            self._enter(State.RETRACTING, "retract was asked for")
            self._after_retract = State.FREE

    def arrived(self, where: str) -> None:
        """The motion of this state has reached its end."""
        if self.state is State.RETRACTING:
            self.touching = False
            forced = self._after_retract is not State.FREE
            reason = self.reason.replace("retracting", "retracted") if forced else where
            self._enter(self._after_retract, reason, Cause.FORCE if forced else Cause.NONE)
        elif self._seeking:
            self._enter(State.HOLD, "nothing felt where the skin should be", Cause.NO_CONTACT)
        elif self.state is State.APPROACH:
            self._enter(State.FREE, where)

    def stop(self, reason: str) -> Action:
        """Give up the motion."""
        if self.state is not State.FAULT:
            self._enter(State.HOLD, reason)
        return Action.STOP

    def pause(self) -> None:
        """Stand still until resumed.

        Raises:
            NotReadyError: When there is no motion to pause.
        """
        if self.state not in (State.APPROACH, State.CONTACT):
            raise NotReadyError(f"nothing to pause in state {self.state.name}")
        seeking, paused_from = self._seeking, self.state
        self._enter(State.HOLD, "paused")
        self._seeking, self._paused_from = seeking and paused_from is State.APPROACH, paused_from

    def resume(self, reading: Reading) -> bool:
        """Go on after a pause, or leave FAULT for HOLD; true when the paused motion goes on.

        Raises:
            NotReadyError: When nothing is paused, or the cause of the fault is still there.
        """
        if self.state is State.FAULT:
            if trouble := self._doubt(reading):
                raise NotReadyError(f"cannot resume: {trouble}")
            self._enter(State.HOLD, "resumed after a fault; retract or go home")
            return False
        if self._paused_from is None:
            raise NotReadyError(f"nothing is paused; the arm is in state {self.state.name}")
        state, self._paused_from = self._paused_from, None
        self.state, self.reason = state, ""
        return True

    def fault(self, reason: str) -> Action:
        """Stand still until the cause is gone and someone resumes."""
        self._enter(State.FAULT, reason, Cause.DATA)
        return Action.STOP

    def trust(self, reading: Reading) -> None:
        """Refuse to begin anything on data that cannot be trusted.

        Raises:
            NotReadyError: With what is wrong.
        """
        if trouble := self._doubt(reading):
            raise NotReadyError(
                f"{trouble}; check the controller, its cable and parameters host, port, udp_port"
            )

    def _enter(self, state: State, reason: str, cause: Cause = Cause.NONE) -> None:
        self.state, self.reason, self.cause = state, reason, cause
        self._seeking, self._paused_from = False, None

    def _doubt(self, reading: Reading) -> str:
        if not reading.connected:
            return "connection to the controller lost"
        if not reading.age <= self._stale_after:
            return f"no state from the controller for {reading.age:.2f} s"
        return "" if np.isfinite(reading.wrench).all() else "force reading is not a number"

    def _excess(self, reading: Reading) -> str:
        """Name the limit that the reading passes; empty when none."""
        waiting = self.touching and self._settled and self.state in (State.CONTACT, State.HOLD)
        passed = limit_passed(reading, self.region, None if self.touching else self._limits.transit)
        return passed or (surge(reading, self._limits) if waiting else "")

    def _leave(self, excess: str, hard: bool) -> Action:
        if not (self.touching or self.moving):  # pushed while it stands in free air
            return Action.GO_ON
        self._enter(State.RETRACTING, f"retracting: {excess}", Cause.FORCE)
        self._after_retract = State.FAULT if hard else State.HOLD
        return Action.RETRACT
