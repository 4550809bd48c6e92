"""The control loop: guard, watchdogs, motion and joint stream in one thread, beside the sensor.

Commands go out on a steady beat. Every sample is judged when it arrives, between the beats too: when the
arm must leave, the next command goes out at once and the beat begins anew from there. What takes time is
planned beforehand. Other threads start motions and read the state under one lock that nobody holds for long.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.errors import ArmConnectionError, ArmError, NotReadyError, UnreachableError
from bathbot_scrub.arm.states import Action, Alarm, State
from bathbot_scrub.rm65.force.wrench_filter import resultant
from bathbot_scrub.rm65.guard.first_samples import FirstSamples
from bathbot_scrub.rm65.guard.force_checks import comfort
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from bathbot_scrub.rm65.guard.watchdogs import UNHEARD, IdleContact, Watchdogs, gravest
from bathbot_scrub.rm65.motion.arm_link import ArmLink, Sensed
from bathbot_scrub.rm65.motion.commanded_motion import (
    ARRIVALS,
    MORE_MAY_COME,
    NOWHERE,
    CommandedMotion,
    MotionKind,
    standing_joints,
)
from bathbot_scrub.rm65.paths.joint_path import JointPath
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner
from bathbot_scrub.rm65.paths.path_runner import Pace, PathRunner
from bathbot_scrub.rm65.paths.retract_path import Retract, RetractPath
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.rm65.timing.beat import Beat, SteadyThread, Stopwatch
from bathbot_scrub.rm65.timing.clock import MONOTONIC, Clock
from bathbot_scrub.rm65.timing.stream_statistics import CommandLog

Array = NDArray[np.float64]
_TRY = "check the controller, its cable and parameters host, port, udp_port"
_REST = 0.5  # [s] the stream goes on after the last motion
_SHORTEST_FRAME = 0.002  # [s] between commands, the least a controller of the third generation takes
_FRESH = 0.02  # [s] age of a sample that tells where the arm is now
NO_PATH = "no path has begun"
_STOOD = 0.1  # [s] without a command after which the controller ends the stream


class ControlLoop:
    """Owns guard and motion; a thread of its own."""

    def __init__(
        self,
        link: ArmLink,
        planner: MotionPlanner,
        guard: ForceGuard,
        settings: DriverSettings,
        warn: Callable[[str], None],
        clock: Clock = MONOTONIC,
    ) -> None:
        """Prepare; `thread.start` begins.

        Args:
            link: Gives what is measured and takes the joint stream.
            planner: Plans the way off the skin.
            guard: Only used under `lock`.
            settings: Period, deadlines, and how to leave.
            warn: Takes one line for the log.
            clock: Of everything here.
        """
        self._clock = clock
        self._period, self._stale_after = 1.0 / settings.rate, settings.stale_after
        self.guard, self.log = guard, CommandLog(self._period)
        self.lock = clock.condition()
        self.alarms: tuple[Alarm, ...] = ()
        self.path_open = False  # a path was begun and its last segment has not come
        self.awaits = NO_PATH  # what the head on the skin waits for, in words
        self.moving = False  # whether a motion is under way; written under the lock only
        self._link, self._watchdogs, self._warn = link, Watchdogs(settings), warn
        retract = Retract(settings.retract_distance, settings.retract_speed)
        self._retract_path = RetractPath(planner, retract, clock)
        self.motion = CommandedMotion(self._retract_path, self._period, planner.limits)
        self._idle_contact, self._rest, self._stopwatch = IdleContact(), 0.0, Stopwatch(clock)
        self.first = FirstSamples(planner.home, guard.limits.transit)
        self.thread = SteadyThread("rm65-control", self._period, self._beat, self._failed, clock)

    @property
    def engaged(self) -> bool:
        """Whether the arm moves, touches, or is about to go on; the caller holds the lock."""
        return self.guard.engaged(self.moving)

    def resume(self) -> None:
        """Let a motion go on that stands; the caller holds the lock."""
        self.moving = self.motion.go_on(self.guard.state) or self.moving

    def extend(self, path: JointPath) -> None:
        """Let a scrub motion run on along a longer path; the caller holds the lock."""
        self.motion.extend(path)
        self.moving = self.moving or self.guard.state is State.CONTACT

    def standing(self) -> Array:
        """Joints [rad], shape (6,), from which a motion begins; NotReadyError while they are in doubt."""
        with self.lock:
            alarm = self.alarm()
            if alarm.doubtful:  # an alarm that has passed lets it begin, and wait for steady data by itself
                raise NotReadyError(f"{alarm.message}; {_TRY}")
            return self.where()

    def where(self) -> Array:
        """Joints [rad], shape (6,), where the arm counts as standing; NotReadyError when that is unknown."""
        still = self._rest if self.motion.runner is None else math.inf
        rest = 0.0 if self.moving else still
        return standing_joints(self.motion.command, self._link.sense(self._clock()).joints, rest)

    def alarm(self) -> Alarm:
        """The gravest of what the watchdogs say now; the caller holds the lock."""
        now = self._clock()
        activity = self._idle_contact.judge(self.guard, self.moving, self.path_open, now)
        activity = activity._replace(waits_for=self._waits_for())
        self.alarms = self._watchdogs.judge(self._link.signals(now, activity), now)
        return gravest(self.alarms)

    def _waits_for(self) -> str:
        """What the head on the skin waits for, in words."""
        if self.guard.paused:
            return "it is paused, and nobody has resumed or retracted it"
        return self.awaits if self.guard.state is State.CONTACT else self.guard.reason

    def begin(self, path: JointPath, pace: Pace, kind: MotionKind, patch: Array = NOWHERE) -> None:
        """Start a motion from rest, as `CommandedMotion.begin`.

        The caller holds the lock and has set the guard's state.

        Raises:
            NotReadyError: The arm moves, or stands elsewhere; it is on no way then.
        """
        try:
            if self.moving:
                raise NotReadyError(f"the arm still moves {self.motion.kind.value}")
            self.motion.begin(path, pace, kind, patch)
        except NotReadyError as error:
            if self.guard.state is State.APPROACH:
                self.guard.stop(str(error))
            raise
        if self.guard.waiting:  # it begins when the wait is over
            self.motion.brake()
        self.moving = True

    def leave(self, alarm: Alarm) -> None:
        """Leave because someone asked; who asks again meanwhile changes nothing. The caller holds the lock.

        Raises:
            NotReadyError, UnreachableError: Joints are in doubt; no way straight back. All is as it was.
        """
        if self.guard.state is State.RETRACTING and (self.moving or self.guard.waiting):
            return
        way = self.motion.way_out(self.where())
        self.guard.begin_retract(alarm)
        self.motion.leave(way)
        if self.guard.waiting:  # it begins when the wait is over
            self.motion.brake()
        self.moving = True

    def give_up(self, runner: PathRunner, reason: str) -> None:
        """Brake, and give a motion up, if it is under way still, or waits to go on by itself."""
        with self.lock:
            if self.motion.runner is runner and self.guard.state in (State.APPROACH, State.CONTACT):
                self.guard.stop(reason)
                self.motion.brake()
                self.lock.notify_all()

    def forget(self) -> None:
        """Command nothing any more; the caller holds the lock."""
        self.motion.forget()
        self._link.told(None, self._clock())
        self._come_to_rest()
        self.log.pause()
        self.lock.notify_all()

    def connection_lost(self) -> None:
        """The controller is gone."""
        with self.lock:
            if self.engaged:
                self.guard.fault("connection to the controller lost")
            self.forget()

    def _beat(self, beat: Beat) -> None:
        """Judge, and send a command when one is due."""
        with self.lock:
            self._note_pause()
            before = self.guard.state, self.guard.waiting, self.alarms
            self._judge(beat)
            joints = None
            if beat.passed():
                self._note_pause()  # whoever was stopped while it judged goes on with nothing of before
                joints = self._advance()
            if (self.guard.state, self.guard.waiting, self.alarms) != before:
                self.lock.notify_all()
        if joints is not None:
            self._send(joints)

    def _failed(self, error: Exception) -> None:
        """A bug, too, must end in an arm that stands still, and be seen."""
        if isinstance(error, ArmConnectionError):
            self.connection_lost()
        else:
            self._fail(str(error) if isinstance(error, ArmError) else f"{type(error).__name__}: {error}")

    def _note_pause(self) -> None:
        """Where process or machine was held up, the controller may have brought the arm to rest; or worse."""
        stood = self._stopwatch.lap()
        if stood > _STOOD:
            self.motion.begin_anew()
        calm = self.guard.state is State.FREE or self.guard.just_started  # nothing can go on there
        if stood > self._stale_after and (self.engaged or not calm):
            raise NotReadyError(
                f"the driver itself stood still for {stood:.2f} s: was it, or the machine, asleep?"
            )

    def _send(self, joints: Array) -> None:
        """Send a command; use the pause behind it to plan the path off the skin."""
        self._link.stream(joints)
        self.log.sent(self._clock())
        if self.guard.touching and self.motion.kind is not MotionKind.LEAVE:
            self._retract_path.prepare(joints)

    def _fail(self, reason: str) -> None:
        with self.lock:
            if self.guard.state is not State.FAULT:
                self._warn(reason)
                self.guard.fault(reason)
            self.motion.stand()
            self._come_to_rest()
            self.lock.notify_all()

    def _judge(self, beat: Beat) -> None:
        sensed, alarm = self._link.sense(self._clock()), self.alarm()
        self._look(sensed, alarm)
        followed = self.motion.kind is MotionKind.LEAVE or not self.engaged
        action = self.guard.check(sensed.reading, alarm, self.moving or self._on_its_way)
        if action is Action.RETRACT:
            self.log.answer(self.guard.over_since)
            self._answer(followed, sensed.reading.sudden[:3])
            beat.bring_forward(self.log.last + _SHORTEST_FRAME)
        elif action is Action.STOP and alarm.astray:
            self._let_stand(sensed)
        elif action is Action.STOP:
            self.motion.brake()
        elif action is Action.RESUME:
            self.resume()
        elif self.guard.state is State.CONTACT:
            self.motion.slow(comfort(resultant(sensed.reading.wrench), self.guard.region).speed)

    def _look(self, sensed: Sensed, alarm: Alarm) -> None:
        """Just started: at home nothing touches the head, anywhere else somebody must say so."""
        home = self._link.connected and self.first.show_home(sensed.reading, sensed.joints, alarm)
        if home and self.guard.just_started:
            self.guard.vouch("at home")
            self.lock.notify_all()

    @property
    def _on_its_way(self) -> bool:
        """Whether the arm stands on a way through free air, or where one ended: near people, maybe."""
        return self.guard.state in (State.APPROACH, State.HOLD) and self.motion.in_free_air

    def _let_stand(self, sensed: Sensed) -> None:
        """Joints or connection are lost: command where the arm is, or nothing that could be obeyed later."""
        if UNHEARD.isdisjoint(one.name for one in self.alarms) and sensed.reading.age <= _FRESH:
            self.motion.stand_at(sensed.joints)
            self._come_to_rest()
            return
        self.forget()
        self._link.stop_behind()

    def _answer(self, followed: bool, push: Array) -> None:
        """Leave who presses on the head, or brake where there is no way; in vain only once for each time."""
        motion = self.motion
        try:
            motion.leave((motion.way_off_follower if followed else motion.way_out)(self.where(), push))
            self.moving = True
        except UnreachableError as error:
            self.guard.could_not_leave()
            self._idle_contact.begin_anew()
            self._warn(str(error))
            self.guard.fault(str(error))
            motion.brake()

    def _come_to_rest(self) -> None:
        self.moving = False
        self.guard.rest()

    def _advance(self) -> Array | None:
        motion = self.motion
        if motion.command is None:
            return None
        self._rest = self._rest + self._period if motion.runner is None else 0.0
        if self._rest > _REST and not (self.guard.touching or self.guard.waiting):
            self.forget()
            return None
        joints = motion.step()
        self._link.told(joints, self._clock())
        if motion.runner is not None and motion.at_rest:
            self._at_rest(motion.runner)
        return joints

    def _at_rest(self, runner: PathRunner) -> None:
        """A motion has come to rest: at its end, or because it was told to brake."""
        if not self.moving:
            return
        self._come_to_rest()
        if runner.at_end and self.motion.kind in ARRIVALS:
            self.guard.arrived(ARRIVALS[self.motion.kind])
        more = MORE_MAY_COME.get(self.motion.kind) is self.guard.state
        if not (more or self.guard.paused or self.guard.waiting):
            self.motion.stand()
        self.lock.notify_all()
