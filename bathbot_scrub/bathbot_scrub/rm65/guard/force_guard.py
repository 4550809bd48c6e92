"""The force guard: what the arm may do next, from force and from what the watchdogs say. Pure.

The states and the ways between them are in `states`. All the guard knows is its `Condition`, which is frozen:
an event puts another in its place, or is refused and changes nothing. Time comes in with the readings, and
whether the arm moves with every call; nobody sets anything from outside.

Whether skin can be felt is no flag of its own that could be lost: in APPROACH it is felt whenever the head
may touch, and only a finished retract says that it does not touch any more.
"""

import numpy as np

from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.force_limits import ForceLimits, RegionLimits
from bathbot_scrub.arm.states import QUIET, Action, Alarm, Cause, Reaction, State
from bathbot_scrub.rm65.force.wrench_filter import resultant
from bathbot_scrub.rm65.guard.condition import Condition
from bathbot_scrub.rm65.guard.force_checks import Reading, limit_passed, surge

_STEADY = 0.01  # [s] of good readings before those of a slope
_NO_FORCE = "force reading is not a number"
_JUST_STARTED = "just started: nobody has said that nothing touches the head"
_GOES_ON = (State.APPROACH, State.CONTACT, State.RETRACTING)  # in which a motion that waited goes on


class ForceGuard:
    """The condition of the arm with regard to the person, and the events that change it."""

    def __init__(
        self, limits: ForceLimits, needs_consent: bool = True, condition: Condition | None = None
    ) -> None:
        """Begin in HOLD, for whom the head touches is not known, or in a condition.

        Args:
            limits: How hard each region may be touched.
            needs_consent: Whether someone must allow to go on after a retract for force.
            condition: Where to begin.
        """
        self.limits, self._needs_consent = limits, needs_consent
        self._now = condition or Condition(
            State.HOLD,
            limits.gentlest(),
            f"{_JUST_STARTED}; see that it is free, then call arm/resume, or arm/retract on the skin",
            Cause.START,
            consent=_JUST_STARTED,
        )

    @property
    def condition(self) -> Condition:
        """All of it, for who keeps or compares it."""
        return self._now

    @property
    def state(self) -> State:
        """What the arm does with regard to the person."""
        return self._now.state

    @property
    def reason(self) -> str:
        """Why it is in this state, for a person; may be empty."""
        return self._now.reason

    @property
    def cause(self) -> Cause:
        """Why the guard ended a motion."""
        return self._now.cause

    @property
    def region(self) -> RegionLimits:
        """Whose skin may be touched."""
        return self._now.region

    @property
    def touching(self) -> bool:
        """Whether the head is on the skin, or so near that it may be."""
        return self._now.touching

    @property
    def felt(self) -> bool:
        """Whether the last reading that could be trusted showed a touch."""
        return self._now.felt

    @property
    def waiting(self) -> str:
        """For what a motion stands until it goes on by itself; empty when it does not."""
        return self._now.waiting

    @property
    def paused(self) -> bool:
        """Whether a motion waits to be resumed by someone."""
        return self._now.paused_from is not None

    @property
    def over_since(self) -> float | None:
        """Stamp of the first sample of the present excess [s]; None without one."""
        return self._now.over_since

    @property
    def just_started(self) -> bool:
        """Whether nothing has been said or done yet."""
        return self._now.cause is Cause.START

    def engaged(self, moving: bool) -> bool:
        """Whether the arm, which moves or not, moves, touches, or is about to go on."""
        return bool(moving or self._now.touching or self._now.waiting)

    def check(self, reading: Reading, alarm: Alarm, moving: bool) -> Action:
        """Judge the newest reading; change the condition, tell what to do at once.

        Args:
            reading: What was felt.
            alarm: The gravest of what the watchdogs say.
            moving: Whether the arm moves.
        """
        trusted = alarm.force and bool(np.isfinite(reading.wrench).all())
        if not trusted and np.isfinite(reading.stamp):  # before the first sample it is no number
            self._set(doubted=reading.stamp)
        if alarm.reaction is not Reaction.FAULT and not (trusted and alarm.joints):
            alarm = alarm._replace(reaction=Reaction.WAIT, message=alarm.message or _NO_FORCE)
        excess = self._excess(reading) if trusted else ""
        self._note(reading, excess, trusted)
        now = self._now
        near = now.touching or now.facing
        if now.state is State.RETRACTING:
            return self._check_leaving(reading, alarm, excess if trusted else None, moving)
        if now.state is State.FAULT:
            return self._check_fault(excess if near else "", alarm, near and not moving)
        met = excess if moving or near else ""  # not while it stands in free air
        if met and alarm.joints:
            faulty = alarm.reaction is Reaction.FAULT
            hard = resultant(reading.sudden) > now.region.hard_stop
            return self._leave(met, State.FAULT if hard or faulty else State.HOLD, broken=faulty)
        if alarm.reaction is Reaction.LEAVE and not moving:
            return self._idle(reading, alarm, near)
        if not (met or self.engaged(moving)):
            return Action.GO_ON
        if alarm.reaction is Reaction.FAULT:
            return self.fault(alarm.message)
        if alarm.reaction is Reaction.WAIT:
            return self._wait(alarm)
        if now.state is State.APPROACH and now.touching and now.felt:
            self._set(state=State.CONTACT, reason="", waiting="", settled=not moving)
            return Action.STOP
        self._set(settled=now.settled or not moving)
        return self._calm()

    def vouch(self, reason: str) -> None:
        """Know that nothing touches the head of an arm that has just started.

        Raises:
            NotReadyError: When something has been done or asked since.
        """
        if not self.just_started:
            raise NotReadyError(f"the arm has not just started; it is in state {self._now.state.name}")
        self._enter(State.FREE, reason)
        self._set(consent="")

    def begin_approach(self, region: RegionLimits, reason: str = "") -> None:
        """Go from FREE or HOLD on the way to a target, through free air.

        Raises:
            NotReadyError: In any other state, on the skin, or while nobody has allowed it.
        """
        now = self._now
        if now.state not in (State.FREE, State.HOLD):
            raise NotReadyError(
                f"the arm is in state {now.state.name} ({now.reason or 'busy'}); "
                "wait until it is free, or call arm/stop or arm/resume"
            )
        if now.touching:
            raise NotReadyError("the head may be on the skin; call arm/retract first")
        if now.consent:
            raise NotReadyError(f"{now.consent}; see that head and way are free, then call arm/resume")
        self._enter(State.APPROACH, reason)
        self._set(region=region, facing=False)

    def begin_seeking(self) -> None:
        """Begin the straight part: from here on the head may touch.

        Raises:
            NotReadyError: When the approach is over.
        """
        if self._now.state is not State.APPROACH:
            raise NotReadyError(f"the approach ended in state {self._now.state.name}: {self._now.reason}")
        self._set(touching=True, settled=False)

    def begin_path(self, region: RegionLimits) -> None:
        """Follow a path over the skin of a region.

        Raises:
            NotReadyError: When the head is not in contact.
        """
        if self._now.state is not State.CONTACT:
            raise NotReadyError(f"a path begins in contact, but the arm is in {self._now.state.name}")
        self._set(region=region)

    def begin_retract(self, alarm: Alarm = QUIET) -> None:
        """Leave because someone asked; in FAULT too, for leaving along the normal needs the joints only.

        While the joints are in doubt, but may not be for long, the motion waits.

        Raises:
            NotReadyError: When joints or commands cannot be trusted, and no waiting will mend that.
        """
        if not alarm.joints and alarm.reaction is Reaction.FAULT:
            raise NotReadyError(f"cannot retract: {alarm.message}; mend it and call arm/resume first")
        if self._now.state is not State.RETRACTING:
            after = State.FAULT if self._now.state is State.FAULT else State.FREE
            self._enter(State.RETRACTING, "retract was asked for")
            self._set(after_retract=after, waiting="" if alarm.joints else alarm.message)

    def arrived(self, where: str) -> None:
        """The motion of this state has reached its end."""
        now = self._now
        if now.state is State.RETRACTING:
            forced = now.after_retract is not State.FREE
            reason = now.reason.replace("retracting", "retracted") if forced else where
            self._enter(now.after_retract, reason, now.cause)
            self._set(touching=False, facing=not now.broken)
        elif now.state is State.APPROACH and now.touching:
            self._enter(State.HOLD, "nothing felt where the skin should be", Cause.NO_CONTACT)
        elif now.state is State.APPROACH:
            self._enter(State.FREE, where)

    def rest(self) -> None:
        """The motion has come to rest; another may begin before the next reading is judged."""
        self._set(settled=True)

    def could_not_leave(self) -> None:
        """There was no way to leave who presses: it is tried again when it is somebody else, or later."""
        self._set(cornered=True)

    def stop(self, reason: str) -> Action:
        """Give up the motion; one that was to end in FAULT ends there."""
        now = self._now
        if now.state is State.RETRACTING and now.after_retract is State.FAULT:
            self._enter(State.FAULT, f"{reason}; {now.reason}", now.cause)
        elif now.state is not State.FAULT:
            self._enter(State.HOLD, reason)
        return Action.STOP

    def pause(self) -> None:
        """Stand still until resumed.

        Raises:
            NotReadyError: When there is no motion to pause.
        """
        paused_from = self._now.state
        if paused_from not in (State.APPROACH, State.CONTACT):
            raise NotReadyError(f"nothing to pause in state {paused_from.name}")
        self._enter(State.HOLD, "paused")
        self._set(paused_from=paused_from)

    def resume(self, alarm: Alarm = QUIET) -> bool:
        """Go on after a pause, allow the next motion, or leave FAULT; true when a paused motion goes on.

        A search during whose pause skin was felt is over: it goes on in contact, and does not move.

        Raises:
            NotReadyError: When none applies, or what the watchdogs say forbids it.
        """
        now = self._now
        if alarm.doubtful:
            raise NotReadyError(f"cannot resume: {alarm.message}")
        if now.state is State.FAULT:
            self._enter(State.HOLD, "resumed after a fault; retract or go home")
            self._set(consent="", broken=False)
            return False
        if now.paused_from is not None:
            found = now.paused_from is State.APPROACH and now.touching and now.felt
            self._enter(State.CONTACT if found else now.paused_from, "")
            return not found
        if now.consent and now.state in (State.HOLD, State.FREE):
            if now.state is State.HOLD and not now.touching:
                self._enter(State.FREE, "allowed to go on")
            self._set(consent="")
            return False
        raise NotReadyError(f"nothing is paused; the arm is in state {now.state.name}")

    def fault(self, reason: str) -> Action:
        """Stand still until the cause is gone and someone resumes."""
        self._enter(State.FAULT, reason, Cause.DATA)
        return Action.STOP

    def _set(self, **changes) -> None:
        self._now = self._now._replace(**changes)

    def _enter(self, state: State, reason: str, cause: Cause = Cause.NONE) -> None:
        self._set(state=state, reason=reason, cause=cause, paused_from=None, waiting="", off=False)

    def _check_fault(self, excess: str, alarm: Alarm, idle: bool) -> Action:
        """Leave in FAULT, too, who presses or is touched for long, if force and joints can be trusted."""
        if not alarm.joints or self._now.cornered:
            return Action.GO_ON
        if excess:
            return self._leave(excess, State.FAULT, broken=self._now.broken)
        if idle and alarm.reaction is Reaction.LEAVE:
            return self._leave(alarm.message, State.FAULT, Cause.IDLE, self._now.broken)
        return Action.GO_ON

    def _check_leaving(self, reading: Reading, alarm: Alarm, excess: str | None, moving: bool) -> Action:
        """While leaving a doubtful force (None) does not hold the arm on the skin, doubtful joints do."""
        if alarm.reaction is Reaction.FAULT:
            if not alarm.joints:
                return self.fault(alarm.message)
            self._set(after_retract=State.FAULT, broken=True, reason=f"retracting: {alarm.message}")
        if alarm.reaction is Reaction.WAIT and not alarm.joints:
            return self._wait(alarm)
        if excess is None:
            return self._calm()
        now, force = self._now, resultant(reading.sudden)
        if force > now.region.hard_stop and now.after_retract is not State.FAULT:
            reason = f"retracting: force {force:.1f} N passed the hard limit"
            self._set(after_retract=State.FAULT, reason=reason)
        after = self._now.after_retract or State.HOLD
        if excess and now.off:  # the person has come after it
            return self._leave(excess, after, broken=now.broken)
        if alarm.reaction is Reaction.LEAVE and not moving:
            return self._leave(alarm.message, after, Cause.IDLE, now.broken)
        rises = any(trend.rise > 0.0 for trend in reading.trends[:1])
        self._set(off=now.off or not (now.felt or rises))
        return self._calm()

    def _wait(self, alarm: Alarm) -> Action:
        """Brake once, and stand for as long as the alarm lasts."""
        waited = self._now.waiting
        self._set(waiting=alarm.message)
        return Action.GO_ON if waited else Action.STOP

    def _calm(self) -> Action:
        """Nothing forbids to go on; what stood because of an alarm goes on."""
        waited = self._now.waiting
        self._set(waiting="")
        return Action.RESUME if waited and self._now.state in _GOES_ON else Action.GO_ON

    def _idle(self, reading: Reading, alarm: Alarm, near: bool) -> Action:
        """Who is touched for long without any motion is left; in free air a person must look what it is."""
        if near:
            return self._leave(alarm.message, State.HOLD, Cause.IDLE)
        asked = self._now.state is State.HOLD and self._now.consent
        if self._now.felt and not asked:
            found = f"{resultant(reading.wrench):.1f} N are felt where nothing should be"
            self._enter(State.HOLD, f"{found}; free the head, then call arm/resume", Cause.IDLE)
            self._set(consent=found)
        return Action.GO_ON

    @property
    def _transit(self) -> float | None:
        return None if self._now.touching or self._now.facing else self.limits.transit

    def _excess(self, reading: Reading) -> str:
        """Name the limit that the reading passes; empty when none."""
        now = self._now
        for wrench in (reading.sudden, reading.wrench):
            if passed := limit_passed(wrench, now.region, self._transit):
                return passed
        if now.state is State.RETRACTING and not now.off:
            return ""
        steady = reading.stamp - now.doubted - _STEADY
        trends = tuple(trend for trend in reading.trends if trend.span <= steady)
        return surge(trends, self.limits, now.settled or not now.touching)

    def _note(self, reading: Reading, excess: str, trusted: bool) -> None:
        """Remember what is felt, and when the first sample over a limit came, to time the answer."""
        now = self._now
        over = excess or limit_passed(reading.raw, now.region, None if now.touching else self.limits.transit)
        since = reading.stamp if now.over_since is None else now.over_since
        # the tool's weight may be off by a newton or two where it was not zeroed; who leaves knows better
        far = self._transit is not None and now.state is not State.RETRACTING
        least = self.limits.transit if far else self.limits.contact
        force = max(resultant(reading.wrench), resultant(reading.sudden))
        self._set(
            over_since=since if over else None,
            felt=force >= least if trusted else now.felt,
            cornered=now.cornered and bool(excess),
        )

    def _leave(self, reason: str, after: State, cause: Cause = Cause.FORCE, broken: bool = False) -> Action:
        self._enter(State.RETRACTING, f"retracting: {reason}", cause)
        forced = self._needs_consent and cause is Cause.FORCE
        consent = "the arm left because of force" if forced else self._now.consent
        self._set(after_retract=after, broken=broken, consent=consent)
        return Action.RETRACT
