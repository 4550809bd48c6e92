"""The watchdogs: what each looks at, its deadline, what the arm does about it. Pure; time is an argument.

`WATCHDOGS` is their table; `Watchdogs` judges by it and remembers for how long; `IdleContact` times how
long the arm stands idle on the skin.

The table in `docs/safety.md` is compared with `WATCHDOGS` by a test. All deadlines are parameters of the
driver. Stamps are monotonic: jumps of the clock of ROS or of the day do not reach this file.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bathbot_scrub.arm.states import QUIET, Alarm, Reaction, State
from bathbot_scrub.rm65.controller.error_codes import in_words
from bathbot_scrub.rm65.controller.state_push import CYCLE
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from bathbot_scrub.rm65.guard.signal_health import Activity, Signals
from bathbot_scrub.rm65.settings import DriverSettings

RATED_FORCE, RATED_TORQUE = 200.0, 7.0  # [N], [Nm] of the sensor; the lower of two documents
_SATURATED = 0.98  # share of it
_REPEATED = 3  # readings of the force in a row that came before: what comes with them may be old, too
_FORCE_SENSOR = (0x2003, 0x2004)  # errors of the controller that leave the joints as they are


class Watchdog(NamedTuple):
    """One row of the table."""

    name: str  # key in the diagnostics
    watches: str
    deadline: str  # parameter of the driver, or "at once"
    reaction: Reaction
    judge: Callable[[Signals, DriverSettings], str]  # what is wrong; empty when nothing is
    force: bool = True  # whether the force can be trusted all the same
    joints: bool = True  # whether the joints can, and the stream of commands


def _silence(signals: Signals, settings: DriverSettings) -> str:
    silent = not signals.age <= settings.brake_after and not signals.refused
    return f"no state from the controller for {signals.age:.2f} s" if silent else ""


def _unreadable(signals: Signals, settings: DriverSettings) -> str:
    bad = not signals.age <= settings.brake_after and signals.refused
    return f"{signals.refused} datagrams of the controller in a row cannot be read" if bad else ""


def _late(signals: Signals, settings: DriverSettings) -> str:
    late = signals.late * CYCLE > settings.brake_after
    return f"{signals.late} samples arrived at once: they were late" if late else ""


def _excess(signals: Signals, settings: DriverSettings) -> str:
    return "more states come than were ordered: somebody else sends some" if signals.excess else ""


def _leap(signals: Signals, settings: DriverSettings) -> str:
    return f"joint {signals.leap} leapt: states of two sources, or old ones" if signals.leap else ""


def _no_force(signals: Signals, settings: DriverSettings) -> str:
    return "" if signals.finite else "force reading is not a number"


def _frozen(signals: Signals, settings: DriverSettings) -> str:
    frozen = signals.repeats >= settings.frozen_samples
    return (
        f"the last {signals.repeats} readings of the force had come before: it is frozen or old"
        if frozen
        else ""
    )


def _saturated(signals: Signals, settings: DriverSettings) -> str:
    force, torque = np.abs(signals.wrench[:3]).max(), np.abs(signals.wrench[3:]).max()
    if not (force >= _SATURATED * RATED_FORCE or torque >= _SATURATED * RATED_TORQUE):
        return ""
    return f"force reading is at the end of its range ({force:.0f} N, {torque:.1f} Nm)"


def _force_error(signals: Signals, settings: DriverSettings) -> str:
    return in_words((code for code in signals.errors if code in _FORCE_SENSOR), ())


def _controller_error(signals: Signals, settings: DriverSettings) -> str:
    return in_words((code for code in signals.errors if code not in _FORCE_SENSOR), ())


def _joint_error(signals: Signals, settings: DriverSettings) -> str:
    return in_words((), signals.joint_errors)


def _live(signals: Signals, settings: DriverSettings) -> bool:
    """Whether the joints are measured now: the force that comes with them would repeat itself else."""
    return signals.age <= settings.brake_after and signals.repeats < _REPEATED


def _following_error(signals: Signals, settings: DriverSettings) -> str:
    late = signals.lag.lasts > settings.following_after * settings.rate
    if not late or not _live(signals, settings):
        return ""
    return f"joint {signals.lag.joint} is {signals.lag.beyond:.3f} rad from where it was told to be"


def _not_following(signals: Signals, settings: DriverSettings) -> str:
    lag = signals.lag
    if lag.told <= settings.still_tolerance or not _live(signals, settings):
        return ""
    return f"joint {lag.still} stands: it was told to go {lag.told:.4f} rad and went {lag.went:.4f} rad"


def _tcp_lost(signals: Signals, settings: DriverSettings) -> str:
    return "" if signals.tcp.connected else "connection to the controller lost"


def _tcp_deaf(signals: Signals, settings: DriverSettings) -> str:
    deaf = signals.tcp.connected and signals.tcp.unanswered > settings.deaf_after
    return f"the controller has not answered for {signals.tcp.unanswered:.2f} s" if deaf else ""


def _no_power(signals: Signals, settings: DriverSettings) -> str:
    return "" if signals.tcp.powered or not signals.tcp.connected else "the arm has no power"


def _starvation(signals: Signals, settings: DriverSettings) -> str:
    return "the arm waits for segments" if signals.activity.starved else ""


def _planner_silence(signals: Signals, settings: DriverSettings) -> str:
    silent = signals.activity.path_open and signals.activity.idle > settings.leave_after
    if not silent:
        return ""
    return (
        f"no segment for {signals.activity.idle:.0f} s on the skin: the planner is silent; "
        f"{signals.activity.waits_for}"
    )


def _idle_contact(signals: Signals, settings: DriverSettings) -> str:
    idle = not signals.activity.path_open and signals.activity.idle > settings.leave_after
    if not idle:
        return ""
    return (
        f"on the skin for {signals.activity.idle:.0f} s without anything to do: {signals.activity.waits_for}"
    )


_WAIT, _LEAVE, _FAULT, _TELL = Reaction.WAIT, Reaction.LEAVE, Reaction.FAULT, Reaction.TELL
WATCHDOGS = (
    Watchdog("silence", "age of the newest sample", "brake_after", _WAIT, _silence, False, False),
    Watchdog("unreadable", "datagrams that are no state", "brake_after", _WAIT, _unreadable, False, False),
    Watchdog("late_samples", "samples that arrive at once", "brake_after", _WAIT, _late),
    Watchdog("excess_samples", "more than were ordered", "at once", _FAULT, _excess, False, False),
    Watchdog("leaping_joints", "joints faster than they can", "at once", _FAULT, _leap, False, False),
    Watchdog("no_force", "force that is not a number", "at once", _WAIT, _no_force, False),
    Watchdog("frozen_force", "readings that came before", "frozen_samples", _FAULT, _frozen, False),
    Watchdog("saturated_force", "two readings at the rated load", "at once", _FAULT, _saturated),
    Watchdog("force_sensor_error", "error codes of the sensor", "at once", _FAULT, _force_error, False),
    Watchdog("joint_error", "error bits of the joints", "at once", _FAULT, _joint_error, True, False),
    Watchdog("controller_error", "all other error codes", "at once", _FAULT, _controller_error, True, False),
    Watchdog(
        "following_error",
        "joints off their commands",
        "following_after",
        _FAULT,
        _following_error,
        True,
        False,
    ),
    Watchdog(
        "not_following",
        "joints that stand when told to go",
        "still_tolerance",
        _FAULT,
        _not_following,
        True,
        False,
    ),
    Watchdog("tcp_lost", "the TCP connection", "at once", _FAULT, _tcp_lost, True, False),
    Watchdog("tcp_deaf", "a question without answer", "deaf_after", _WAIT, _tcp_deaf, True, False),
    Watchdog("no_power", "the arm's power", "at once", _FAULT, _no_power, True, False),
    Watchdog("planner_silence", "a path without new segments", "leave_after", _LEAVE, _planner_silence),
    Watchdog("idle_contact", "skin touched, nothing to do", "leave_after", _LEAVE, _idle_contact),
    Watchdog("queue_starvation", "the queue of segments", "at once", _TELL, _starvation),
)
UNHEARD = frozenset({"silence", "unreadable", "tcp_deaf"})  # commands may wait on their way for later
UNSTEADY = "unsteady"  # the name of waiting on, after an alarm that has passed


class Watchdogs:
    """Judges the signals, and remembers for how long something has been wrong."""

    def __init__(self, settings: DriverSettings) -> None:
        """Take the deadlines from `settings`."""
        self._settings = settings
        self._since: dict[str, float] = {}  # [s] when each alarm that makes the arm wait began
        self._waiting_since: float | None = None
        self._last_wait = -np.inf

    def judge(self, signals: Signals, now: float) -> tuple[Alarm, ...]:
        """All alarms at `now` [s]; what makes the arm wait becomes a fault when it lasts."""
        alarms = []
        for dog in WATCHDOGS:
            message = dog.judge(signals, self._settings)
            if not message:
                self._since.pop(dog.name, None)
                continue
            alarm = Alarm(dog.name, dog.reaction, message, dog.force, dog.joints)
            alarms.append(self._lasting(alarm, now) if dog.reaction is Reaction.WAIT else alarm)
        return tuple(alarms + self._unsteady(alarms, now))

    def _lasting(self, alarm: Alarm, now: float) -> Alarm:
        begun = self._since.setdefault(alarm.name, now)
        self._last_wait = now
        self._waiting_since = now if self._waiting_since is None else self._waiting_since
        lasts = now - begun > self._settings.stale_after - self._settings.brake_after
        return alarm._replace(reaction=Reaction.FAULT) if lasts else alarm

    def _unsteady(self, alarms: list[Alarm], now: float) -> list[Alarm]:
        """Wait on for a while behind every alarm, but not for ever."""
        if self._waiting_since is None:
            return []
        if now - self._last_wait >= self._settings.steady_for:
            self._waiting_since = None
            return []
        if now - self._waiting_since > self._settings.wait_at_most:
            return [Alarm(UNSTEADY, Reaction.FAULT, "the controller's data come and go", True, True)]
        if self._last_wait == now:
            return []
        return [Alarm(UNSTEADY, Reaction.WAIT, "waits for the controller's data to be steady")]


def gravest(alarms: Sequence[Alarm]) -> Alarm:
    """The gravest alarm, with the trust that all of them leave; QUIET when there is none."""
    if not alarms:
        return QUIET
    worst = max(alarms, key=lambda alarm: alarm.reaction)
    return worst._replace(
        force=all(alarm.force for alarm in alarms), joints=all(alarm.joints for alarm in alarms)
    )


class IdleContact:
    """Times the arm's standing still while it touches, in any state."""

    def __init__(self) -> None:
        """Begin off the skin."""
        self._idle_since: float | None = None
        self._state = State.FREE

    def begin_anew(self) -> None:
        """What was to be done about it could not be done: it is tried again after as long."""
        self._idle_since = None

    def judge(self, guard: ForceGuard, moving: bool, path_open: bool, now: float) -> Activity:
        """What the arm does at `now` [s].

        Args:
            guard: Knows whether a touch is felt, or must be.
            moving: Whether the arm moves.
            path_open: A path was begun, and more of it must come.
            now: Time [s].
        """
        held = guard.touching and guard.state in (State.CONTACT, State.HOLD)
        if moving or not (held or guard.felt) or guard.state is not self._state:
            self._idle_since, self._state = None, guard.state
        if moving or not (held or guard.felt):
            return Activity(False, 0.0, path_open)
        self._idle_since = now if self._idle_since is None else self._idle_since
        starved = path_open and guard.state is State.CONTACT and not guard.waiting
        return Activity(starved, now - self._idle_since, path_open)
