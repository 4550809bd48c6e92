"""The 100 Hz loop: guard, motion and joint stream in one thread, beside the sensor.

Everything it needs is computed beforehand; a period costs well below a millisecond. Other threads
start motions and read the state under one lock that nobody holds for long.
"""

import threading
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.client import ArmClient
from bathbot_scrub.rm65.errors import ArmConnectionError, ArmError, NotReadyError
from bathbot_scrub.rm65.force_guard import Action, ForceGuard, State
from bathbot_scrub.rm65.joint_path import JointPath
from bathbot_scrub.rm65.limits import RM65_LIMITS
from bathbot_scrub.rm65.link import Sensed
from bathbot_scrub.rm65.motion import Planner, line_pace
from bathbot_scrub.rm65.motion_kind import Kind
from bathbot_scrub.rm65.path_runner import Pace, PathRunner
from bathbot_scrub.rm65.period import Beat, PeriodStatistics, raise_priority

Array = NDArray[np.float64]
_REST = 0.5  # [s] the stream goes on after the last motion
_LEAVE_JERK = 400.0  # [m/s^3]: haste matters more than smoothness
_SHORTEST_RETRACT = 0.02  # [m]
_WAY_BACK = 0.8  # [rad] back on a joint move that met something
_BACK_JOINTS = Pace(1.0, 8.0, 400.0)
_STOP_LINE = line_pace(0.0, 2.0)  # braking on tool paths [m/s^2]
_STOP_JOINTS = Pace(0.0, 8.0, 400.0)  # braking of joint moves [rad/s^2], [rad/s^3]


class Retract(NamedTuple):
    """How the arm leaves the skin."""

    distance: float  # [m]
    speed: float  # [m/s]
    acceleration: float = 4.0  # [m/s^2]


class ControlLoop:
    """Owns the guard and the motion; a thread of its own."""

    def __init__(
        self,
        client: ArmClient,
        planner: Planner,
        guard: ForceGuard,
        sense: Callable[[], Sensed],
        retract: Retract,
        period: float,
        warn: Callable[[str], None],
    ) -> None:
        """Prepare; `start` begins.

        Args:
            client: Takes the joint stream.
            planner: Plans the way off the skin.
            guard: Judges every reading; only used under `lock`.
            sense: Gives what was measured last.
            retract: How to leave.
            period: Of the loop [s].
            warn: Takes one line for the log.
        """
        self.guard, self.statistics = guard, PeriodStatistics(period)
        self.lock = threading.Condition(threading.RLock())
        self.command: Array | None = None  # joints last commanded [rad]; None: not streaming
        self.runner: PathRunner | None = None
        self.kind = Kind.TRANSIT
        self.priority = ""
        self._client, self._planner, self._sense, self._retract = client, planner, sense, retract
        self._period, self._warn = period, warn
        self._pace = _STOP_LINE
        self._trail: tuple[PathRunner, Array] | None = None  # motion still braking while the next one runs
        self._rest = 0.0
        self._open = True
        self._thread = threading.Thread(target=self._run, name="rm65-control", daemon=True)

    def start(self) -> None:
        """Begin to beat."""
        self._thread.start()

    def close(self) -> None:
        """End the thread."""
        self._open = False
        if self._thread.is_alive():
            self._thread.join(2.0)

    def resume(self) -> None:
        """Let a paused motion go on; the caller holds the lock."""
        if self.runner is not None:
            self.runner.go_on(self._pace)
            self.guard.moving = True

    def extend(self, path: JointPath) -> None:
        """Let a scrub motion run on along a longer path; the caller holds the lock."""
        if self.runner is None or self.kind is not Kind.SCRUB:
            raise NotReadyError(
                f"the arm follows no path any more ({self.guard.reason or self.guard.state.name})"
            )
        self.runner.replace(path)
        self.guard.moving = self.guard.moving or self.guard.state is State.CONTACT

    def standing(self) -> Array:
        """Joints [rad], shape (6,), from which a motion begins: last commanded, else measured just now.

        Raises:
            NotReadyError: While nothing is commanded and nothing recent measured.
        """
        with self.lock:
            if self.command is not None:
                return self.command
            sensed = self._sense()
            self.guard.trust(sensed.reading)
            return sensed.joints

    def begin(self, path: JointPath, pace: Pace, kind: Kind) -> None:
        """Start a motion from rest; the caller holds the lock and has set the guard's state.

        Raises:
            NotReadyError: When another motion runs, or the path begins elsewhere.
        """
        if self.guard.moving:
            raise NotReadyError(f"the arm still moves {self.kind.value}")
        start = path.joints[0]
        if self.command is not None and np.abs(start - self.command).max() > 0.02:
            raise NotReadyError("the motion was planned from elsewhere; ask again")
        self.runner, self.kind, self._trail = PathRunner(path, pace, self._period), kind, None
        self._pace = pace
        self.command = start if self.command is None else self.command
        self.guard.moving = True

    def brake(self) -> None:
        """Bring the motion to rest on its path."""
        if self.runner is not None:
            self.runner.brake(_STOP_JOINTS if self.kind in (Kind.TRANSIT, Kind.HOME) else _STOP_LINE)

    def leave(self, joints: Array) -> None:
        """Leave along the outward normal at once while other motion brakes; in free air, the way it came.

        Args:
            joints: As measured [rad], shape (6,), from which to leave when nothing was commanded.

        Raises:
            UnreachableError: When there is no way straight back.
        """
        self._trail = None
        start = self.command = joints if self.command is None else self.command
        if self.runner is not None and not self.runner.at_rest:
            self.brake()
            self._trail = (self.runner, self.runner.path.at(self.runner.length))
        if self._trail is not None and self.kind in (Kind.TRANSIT, Kind.HOME):
            path, pace = self._trail[0].path.back_from(self._trail[0].length, _WAY_BACK), _BACK_JOINTS
        else:
            path = self._planner.line(start, -self._retract.distance, self._retract.speed, _SHORTEST_RETRACT)
            pace = Pace(self._retract.speed, self._retract.acceleration, _LEAVE_JERK)
        self.runner, self.kind = PathRunner(path, pace, self._period), Kind.LEAVE
        self.guard.moving = True

    def connection_lost(self) -> None:
        """The controller is gone: whatever was commanded no longer counts."""
        with self.lock:
            if self.guard.moving or self.guard.touching:
                self.guard.fault("connection to the controller lost")
            self.runner, self._trail, self.command = None, None, None
            self.guard.moving = False
            self.statistics.pause()
            self.lock.notify_all()

    def _run(self) -> None:
        self.priority = raise_priority()
        beat = Beat(self._period)
        while self._open:
            beat.wait()
            try:
                joints = self._period_passed()
                if joints is not None:
                    self._client.stream_joints(joints)
                    self.statistics.tick(time.monotonic())
            except ArmConnectionError:
                self.connection_lost()
            except ArmError as error:
                self._fail(str(error))
            except Exception as error:  # a bug must end in an arm that stands still, and be seen
                self._fail(f"{type(error).__name__}: {error}")

    def _fail(self, reason: str) -> None:
        with self.lock:
            if self.guard.state is not State.FAULT:
                self._warn(reason)
                self.guard.fault(reason)
            self.runner, self._trail = None, None
            self.guard.moving = False
            self.lock.notify_all()

    def _period_passed(self) -> Array | None:
        """Judge, move on by one period; give the joints to send, or None when nothing needs to be sent."""
        with self.lock:
            before = self.guard.state
            sensed = self._sense()
            action = self.guard.check(sensed.reading)
            if action is Action.RETRACT:
                self.leave(sensed.joints)
            elif action is Action.STOP:
                self.brake()
            joints = self._advance()
            if self.guard.state is not before:
                self.lock.notify_all()
            return joints

    def _advance(self) -> Array | None:
        if self.command is None:
            return None
        if self.runner is None:
            self._rest += self._period
            if self._rest > _REST and self.guard.state is not State.CONTACT and not self.guard.touching:
                self.command = None
                self.statistics.pause()
            return self.command
        self._rest = 0.0
        joints = self.runner.step()
        if self._trail is not None:
            trail, origin = self._trail
            joints = joints + trail.step() - origin
        RM65_LIMITS.check(joints)
        RM65_LIMITS.check_step(self.command, joints, self._period)
        self.command = joints
        if self.runner.at_rest and (self._trail is None or self._trail[0].at_rest):
            self._at_rest(self.runner)
        return joints

    def _at_rest(self, runner: PathRunner) -> None:
        """A motion has come to rest: at its end, or because it was told to brake."""
        if not self.guard.moving:
            return
        self.guard.moving = False
        scrubbing = self.kind is Kind.SCRUB and self.guard.state is State.CONTACT
        if runner.at_end and self.kind in (Kind.SEEK, Kind.LEAVE, Kind.HOME):
            self.guard.arrived("at home" if self.kind is Kind.HOME else "retracted")
        if not (scrubbing or self.guard.paused):
            self.runner, self._trail = None, None
        self.lock.notify_all()
