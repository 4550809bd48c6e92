"""The force guard: what the arm may do next, from force and from what the watchdogs say. Pure.

The states and the ways between them are in `states`. Time comes in with the readings.
"""

import numpy as np

from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.force_limits import ForceLimits, RegionLimits
from bathbot_scrub.arm.states import QUIET, Action, Alarm, Cause, Reaction, State
from bathbot_scrub.rm65.force.wrench_filter import resultant
from bathbot_scrub.rm65.guard.force_checks import Reading, limit_passed, surge

_SLOPE = 0.03  # [s] of good readings that a slope needs


class ForceGuard:
    """The state of the arm with regard to the person."""

    def __init__(self, limits: ForceLimits, needs_consent: bool = True) -> None:
        """Begin FREE. With `needs_consent` someone must allow to go on after a retract for force."""
        self._limits, self._needs_consent = limits, needs_consent
        self.state, self.reason, self.cause = State.FREE, "", Cause.NONE
        self.region: RegionLimits = limits.gentlest()
        self.touching = False  # on the skin, or so near that it may be
        self.facing = False  # it has left a person, who may follow
        self.moving = False  # set by the control loop
        self.waiting = ""  # for what the motion stands until it goes on by itself; empty: it does not
        self.over_since: float | None = None  # [s] stamp of the first sample of the present excess
        self._seeking = False
        self._settled = False  # the search has come to rest: a rise of force is the body's doing now
        self._off = False  # while leaving: nothing is felt any more
        self._broken = False  # it leaves for a force that comes with a fault: of the sensor, maybe
        self._doubted = -np.inf  # [s] stamp of the last reading that could not be trusted
        self.cornered = False  # it could not leave who presses now
        self._forced = False  # the arm left because of force, and nobody has allowed it to go on
        self._paused_from: State | None = None
        self._after_retract = State.FREE

    @property
    def engaged(self) -> bool:
        """Whether the arm moves, touches, or is about to go on."""
        return bool(self.moving or self.touching or self.waiting)

    @property
    def paused(self) -> bool:
        """Whether a motion waits to be resumed by someone."""
        return self._paused_from is not None

    def check(self, reading: Reading, alarm: Alarm = QUIET) -> Action:
        """Judge the newest reading, and what the watchdogs say; change the state, tell what to do at once."""
        trusted = alarm.force and bool(np.isfinite(reading.wrench).all())
        self._doubted = self._doubted if trusted else reading.stamp
        excess = self._excess(reading) if trusted else ""
        self._note_first(reading, excess)
        self.cornered = self.cornered and bool(excess)
        if self.state is State.FAULT:  # still leaves when pressed, if force and joints can be trusted
            pressed = excess and not self.cornered and (self.touching or self.facing) and alarm.joints
            return self._leave(excess, State.FAULT) if pressed else Action.GO_ON
        if self.state is State.RETRACTING:
            return self._check_leaving(reading, alarm, excess if trusted else None)
        met = excess if self.moving or self.touching or self.facing else ""  # not while it stands in free air
        if not (met or self.engaged):
            return Action.GO_ON
        faulty = alarm.reaction is Reaction.FAULT
        if met and alarm.joints:
            self._broken = faulty
            hard = resultant(reading.sudden) > self.region.hard_stop
            return self._leave(met, State.FAULT if hard or faulty else State.HOLD)
        if faulty:
            return self.fault(alarm.message)
        if alarm.reaction is Reaction.WAIT:
            return self._wait(alarm)
        if alarm.reaction is Reaction.LEAVE and self.touching and not self.moving:
            return self._leave(alarm.message, State.HOLD, Cause.IDLE)
        if self._seeking and trusted and self._felt(reading):
            self._seeking = self._settled = False
            self.state, self.reason, self.waiting = State.CONTACT, "", ""
            return Action.STOP
        self._settled = self._settled or not self.moving
        return self._calm()

    def begin_approach(self, region: RegionLimits, reason: str = "") -> None:
        """Go from FREE or HOLD on the way to a target, through free air.

        Raises:
            NotReadyError: In any other state, on the skin, or while nobody has allowed it.
        """
        if self.state not in (State.FREE, State.HOLD):
            raise NotReadyError(
                f"the arm is in state {self.state.name} ({self.reason or 'busy'}); "
                "wait until it is free, or call arm/stop or arm/resume"
            )
        if self.touching:
            raise NotReadyError("the head may be on the skin; call arm/retract first")
        if self._forced:
            raise NotReadyError("the arm left because of force; see whether the way is free, then arm/resume")
        self._enter(State.APPROACH, reason)
        self.region, self.facing = region, False

    def begin_seeking(self) -> None:
        """Begin the straight part: from here on the head may touch."""
        if self.state is not State.APPROACH:
            raise NotReadyError(f"the approach ended in state {self.state.name}: {self.reason}")
        self._seeking = self.touching = True
        self._settled = False

    def begin_retract(self, alarm: Alarm = QUIET) -> None:
        """Leave because someone asked; in FAULT too, for leaving along the normal needs the joints only.

        Raises:
            NotReadyError: When joints or commands cannot be trusted, and no waiting will mend that.
        """
        if not alarm.joints and alarm.reaction is Reaction.FAULT:
            raise NotReadyError(f"cannot retract: {alarm.message}; mend it and call arm/resume first")
        if self.state is not State.RETRACTING:
            faulted = self.state is State.FAULT
            self._enter(State.RETRACTING, "retract was asked for")
            self._after_retract = State.FAULT if faulted else State.FREE

    def arrived(self, where: str) -> None:
        """The motion of this state has reached its end."""
        if self.state is State.RETRACTING:
            self.touching, self.facing = False, not self._broken
            forced = self._after_retract is not State.FREE
            reason = self.reason.replace("retracting", "retracted") if forced else where
            self._enter(self._after_retract, reason, self.cause)
        elif self._seeking:
            self._enter(State.HOLD, "nothing felt where the skin should be", Cause.NO_CONTACT)
        elif self.state is State.APPROACH:
            self._enter(State.FREE, where)

    def rest(self) -> None:
        """The motion has come to rest; another may begin before the next reading is judged."""
        self.moving, self._settled = False, True

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

    def resume(self, alarm: Alarm = QUIET) -> bool:
        """Go on after a pause, allow the next motion, or leave FAULT; true when a paused motion goes on.

        Raises:
            NotReadyError: When none applies, or what the watchdogs say forbids it.
        """
        if alarm.doubtful:
            raise NotReadyError(f"cannot resume: {alarm.message}")
        if self.state is State.FAULT:
            self._forced = False
            self._enter(State.HOLD, "resumed after a fault; retract or go home")
            return False
        if self._paused_from is not None:
            state, self._paused_from = self._paused_from, None
            self.state, self.reason = state, ""
            return True
        if self._forced and self.state in (State.HOLD, State.FREE):
            self._forced = False
            if self.state is State.HOLD and not self.touching:
                self._enter(State.FREE, "allowed to go on")
            return False
        raise NotReadyError(f"nothing is paused; the arm is in state {self.state.name}")

    def fault(self, reason: str) -> Action:
        """Stand still until the cause is gone and someone resumes."""
        self._enter(State.FAULT, reason, Cause.DATA)
        return Action.STOP

    def _enter(self, state: State, reason: str, cause: Cause = Cause.NONE) -> None:
        self.state, self.reason, self.cause = state, reason, cause
        self._seeking, self._paused_from, self.waiting, self._off = False, None, "", False

    def _check_leaving(self, reading: Reading, alarm: Alarm, excess: str | None) -> Action:
        """While leaving a doubtful force (None) does not hold the arm on the skin, doubtful joints do."""
        if alarm.reaction is Reaction.FAULT:
            if not alarm.joints:
                return self.fault(alarm.message)
            self._after_retract, self._broken = State.FAULT, True
            self.reason = f"retracting: {alarm.message}"
        if alarm.reaction is Reaction.WAIT and not alarm.joints:
            return self._wait(alarm)
        if excess is None:
            return self._calm()
        force = resultant(reading.sudden)
        if force > self.region.hard_stop and self._after_retract is not State.FAULT:
            self._after_retract = State.FAULT
            self.reason = f"retracting: force {force:.1f} N passed the hard limit"
        if excess and self._off:  # the person has come after it
            return self._leave(excess, self._after_retract or State.HOLD)
        self._off = self._off or not self._felt(reading)
        return self._calm()

    def _wait(self, alarm: Alarm) -> Action:
        """Brake once, and stand for as long as the alarm lasts."""
        waited, self.waiting = self.waiting, alarm.message
        return Action.GO_ON if waited else Action.STOP

    def _calm(self) -> Action:
        """Nothing forbids to go on; what stood because of an alarm goes on."""
        waited, self.waiting = self.waiting, ""
        return Action.RESUME if waited else Action.GO_ON

    def _felt(self, reading: Reading) -> bool:
        """Whether skin is felt."""
        return max(resultant(reading.wrench), resultant(reading.sudden)) >= self._limits.contact

    @property
    def _transit(self) -> float | None:
        return None if self.touching or self.facing else self._limits.transit

    def _excess(self, reading: Reading) -> str:
        """Name the limit that the reading passes; empty when none."""
        for wrench in (reading.sudden, reading.wrench):
            if passed := limit_passed(wrench, self.region, self._transit):
                return passed
        near = self.facing or (self.touching and (self._off or self.state is not State.RETRACTING))
        if not near or reading.stamp - self._doubted < _SLOPE:
            return ""
        return surge(reading, self._limits, self._settled or not self.touching)

    def _note_first(self, reading: Reading, excess: str) -> None:
        """Remember when the first sample over a limit came, to know how long the answer takes."""
        over = excess or limit_passed(
            reading.raw, self.region, None if self.touching else self._limits.transit
        )
        since = reading.stamp if self.over_since is None else self.over_since
        self.over_since = since if over else None

    def _leave(self, reason: str, after: State, cause: Cause = Cause.FORCE) -> Action:
        self._forced = self._forced or (self._needs_consent and cause is Cause.FORCE)
        self._enter(State.RETRACTING, f"retracting: {reason}", cause)
        self._after_retract = after
        return Action.RETRACT
