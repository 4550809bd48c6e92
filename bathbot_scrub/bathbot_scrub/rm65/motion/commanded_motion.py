"""What the arm is commanded: the kinds of motion, the one being streamed, and where it stands at rest.

A motion is a path with its pace. What is left of the one before it may still brake while it begins.
"""

from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.errors import NotReadyError, UnreachableError
from bathbot_scrub.arm.joint_limits import JointLimits
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.paths.free_air import FASTEST, Along, OnWay
from bathbot_scrub.rm65.paths.joint_path import JointPath
from bathbot_scrub.rm65.paths.path_runner import Pace, PathRunner
from bathbot_scrub.rm65.paths.retract_path import RetractPath

Array = NDArray[np.float64]
NOWHERE: Array = np.empty((0, 3))
_ASTRAY = 0.03  # [rad] between command and measurement, at rest, above which the measurement counts
_SETTLING = 0.2  # [s] after the last motion in which the arm still catches up with its command
# along a way through free air on which something was met; as for a retract, the joints limit what follows
_BACK_JOINTS = Pace(FASTEST, 25.0, 1e4)
_STRAIGHT = 0.08  # [m] that a way through free air must give in to be better than the straight line
_FELT = 0.3  # [N] of a push whose direction is known
_STOP_LINE = Pace(0.0, 4.0, 1000.0)  # braking on tool paths [m/s^2], [m/s^3], if no joint turns far
# braking of joints [rad/s^2], [rad/s^3]: as hard as the controller lets them, for who is told to stop harder
# than that overshoots and comes back
_STOP_JOINTS = Pace(0.0, 10.0, 2000.0)
_STOP_WITHIN = 0.02  # [m] in which a tool path is left, or at least most of its speed


class MotionKind(Enum):
    """What a motion is for."""

    TRANSIT = "to the stand-off"
    SEEK = "towards the skin"
    SCRUB = "along the path"
    LEAVE = "away from the skin"
    HOME = "home"
    PROGRAM = "where a program sent it"
    STREAM = "after a stream of joints"


ARRIVALS = {  # motions whose end ends a state, and what is said then
    MotionKind.SEEK: "at the end of the search",
    MotionKind.LEAVE: "retracted",
    MotionKind.HOME: "at home",
    MotionKind.PROGRAM: "where it was sent",
}

MORE_MAY_COME = {  # motions that may rest at what came so far, and the state in which they do
    MotionKind.SCRUB: State.CONTACT,
    MotionKind.STREAM: State.APPROACH,
}

# through free air, lengths in [rad]
_JOINT_MOVES = (MotionKind.TRANSIT, MotionKind.HOME, MotionKind.PROGRAM, MotionKind.STREAM)
_STATE_OF = {  # in which a motion of a kind may go on after a stop
    MotionKind.TRANSIT: State.APPROACH,
    MotionKind.SEEK: State.APPROACH,
    MotionKind.HOME: State.APPROACH,
    MotionKind.PROGRAM: State.APPROACH,
    MotionKind.STREAM: State.APPROACH,
    MotionKind.SCRUB: State.CONTACT,
    MotionKind.LEAVE: State.RETRACTING,
}


class WayOut(NamedTuple):
    """How to leave, planned before anything that runs is touched."""

    start: Array  # joints [rad], shape (6,), where it begins
    path: JointPath
    pace: Pace
    along: Along | None = None  # the part of a way through free air that the path is


class CommandedMotion:
    """Gives the joints to command, period by period. Not thread-safe."""

    def __init__(self, retract_path: RetractPath, period: float, limits: JointLimits) -> None:
        """Nothing is commanded yet.

        Args:
            retract_path: Gives the way off the skin.
            period: Of the commands [s].
            limits: Of the joints; nothing beyond is ever commanded.
        """
        self.command: Array | None = None  # joints last commanded [rad]; None: not streaming
        self.runner: PathRunner | None = None
        self.kind, self.patch = MotionKind.TRANSIT, NOWHERE
        self._retract_path, self._period, self._limits = retract_path, period, limits
        self._pace = _STOP_LINE
        self._trail: tuple[PathRunner, Array] | None = None  # motion still braking while the next one runs
        self._came: OnWay | None = None  # the way through free air on which the arm stands
        self._along: Along | None = None  # what it leaves along

    @property
    def at_rest(self) -> bool:
        """Whether nothing that is commanded moves, nor goes on by itself."""
        return (self.runner is None or self.runner.stands) and (self._trail is None or self._trail[0].at_rest)

    @property
    def in_free_air(self) -> bool:
        """Whether the arm is on a way through free air, or stands where one ended."""
        return self._on_way is not None

    @property
    def _on_way(self) -> OnWay | None:
        if self.runner is not None and self.kind in _JOINT_MOVES:
            return OnWay(self.runner.path, self.runner.length)
        if self.runner is not None and self._along is not None:
            return self._along.at(self.runner.length)
        return self._came

    def begin(self, path: JointPath, pace: Pace, kind: MotionKind, patch: Array = NOWHERE) -> None:
        """Start from rest.

        Args:
            path: Where to.
            pace: How fast.
            kind: What for.
            patch: Places, shape (K, 3) [m], about which the head may touch the body.

        Raises:
            NotReadyError: When the path begins elsewhere.
        """
        start = path.joints[0]
        if self.command is not None and np.abs(start - self.command).max() > 0.02:
            raise NotReadyError("the motion was planned from elsewhere; ask again")
        self.runner, self.kind, self._trail = PathRunner(path, pace, self._period), kind, None
        self._pace, self._came, self._along, self.patch = pace, None, None, patch
        self.command = start if self.command is None else self.command

    def extend(self, path: JointPath) -> None:
        """Run on along a longer scrub path.

        Raises:
            NotReadyError: When no path is being followed.
        """
        if self.runner is None or self.kind is not MotionKind.SCRUB:
            raise NotReadyError("the arm follows no path any more")
        self.runner.replace(path)

    def retarget(self, path: JointPath, cut: float) -> None:
        """Run on after a stream; lengths on its path are now less by `cut` [rad].

        Raises:
            NotReadyError: When no stream is being followed.
        """
        if self.runner is None or self.kind is not MotionKind.STREAM:
            raise NotReadyError("the arm follows no stream any more")
        self.runner.rebase(path, cut)

    def brake(self) -> None:
        """Come to rest on the path, as fast as the head may and every joint can."""
        if self.runner is None:
            return
        if self.kind in _JOINT_MOVES:
            self.runner.brake(_STOP_JOINTS)
            return
        steepest = self.runner.path.steepest(self.runner.length, _STOP_WITHIN)
        share = min(_STOP_JOINTS.acceleration / (_STOP_LINE.acceleration * max(steepest, 1e-9)), 1.0)
        self.runner.brake(Pace(0.0, share * _STOP_LINE.acceleration, share * _STOP_LINE.jerk))

    def begin_anew(self) -> None:
        """Nothing was commanded for so long that the arm stands: what follows begins from rest."""
        self._trail = None
        if self.runner is not None:
            self.runner.begin_anew()

    def go_on(self, state: State) -> bool:
        """Go on after a brake, if the motion suits the state of the arm; tell whether it does."""
        if self.runner is None or _STATE_OF[self.kind] is not state:
            return False
        self.runner.go_on(self._pace)
        return True

    def slow(self, share: float) -> None:
        """Let a scrub motion use a share of its speed, 0..1."""
        if self.runner is not None and self.kind is MotionKind.SCRUB:
            self.runner.share = share

    def way_out(self, start: Array, push: Array | None = None) -> WayOut:
        """Plan to leave along the outward normal; in free air, along the way it came. Changes nothing.

        Args:
            start: Joints [rad], shape (6,), last commanded or measured.
            push: Force on the head that is left, its own frame [N], shape (3,): in free air the way, back or
                on, gives in to it, or else the straight line does.

        Raises:
            UnreachableError: When there is no way straight back.
        """
        way, arm, speed = self._on_way, self._retract_path.arm, self._retract_path.pace.speed
        if way is None or not way.holds(start):
            return self._straight(start)
        if push is not None and np.linalg.norm(push) >= _FELT:
            push = arm.head(start)[:3, :3] @ push
            along = way.yielding(arm, push, speed, _STRAIGHT)
            if along is None:
                try:
                    return self._straight(start)
                except UnreachableError:
                    along = way.yielding(arm, push, speed)
                    if along is None:
                        raise
            return WayOut(start, along.path, _BACK_JOINTS, along)
        if self.runner is None or self.at_rest:
            return self._straight(start)
        along = way.back(arm, speed)
        return WayOut(start, along.path, _BACK_JOINTS, along)

    def _straight(self, start: Array) -> WayOut:
        return WayOut(start, self._retract_path.path(start), self._retract_path.pace)

    def way_off_follower(self, start: Array, push: Array | None = None) -> WayOut:
        """Plan to leave someone who has come after the arm: what lies behind it now is no way it came.

        Raises:
            UnreachableError: As `way_out`; a CollisionError when something known is in the way.
        """
        way = self.way_out(start, push)
        self._retract_path.demand_free(way.path)
        return way

    def leave(self, way: WayOut) -> None:
        """Leave at once while other motion brakes; a straight line out takes the place of another."""
        before, trail = self.runner, None if self._trail is None else self._trail[0]
        if before is None or before.at_rest:
            trail = None
        elif not (self.kind is MotionKind.LEAVE and self._pace == way.pace):
            self.brake()
            trail = before
        self._trail = None if trail is None else (trail, trail.path.at(trail.length))
        self.command, self._pace, self._came, self._along = way.start, way.pace, None, way.along
        self.runner, self.kind = PathRunner(way.path, way.pace, self._period), MotionKind.LEAVE

    def stand_at(self, joints: Array) -> None:
        """Give the motion up and stay at joints [rad], shape (6,): the arm is not where it was told to be."""
        self.stand()
        self.command, self._came = joints, None

    def stand(self) -> None:
        """Give the motion up; what was commanded last stays commanded."""
        self._came = self._on_way
        self.runner, self._trail, self._along = None, None, None

    def forget(self) -> None:
        """Command nothing any more."""
        self.stand()
        self.command = None

    def step(self) -> Array:
        """Joints [rad], shape (6,), to command one period later; something must be commanded.

        Raises:
            ArmError: When they would pass a limit.
        """
        if self.runner is None:
            return self.command
        joints = self.runner.step()
        if self._trail is not None:
            trail, origin = self._trail
            joints = joints + trail.step() - origin
        self._limits.check(joints)
        self._limits.check_step(self.command, joints, self._period)
        self.command = joints
        return joints


def standing_joints(command: Array | None, measured: Array, rest: float) -> Array:
    """Joints [rad], shape (6,): last commanded, or measured where nothing was or the arm is elsewhere.

    Args:
        command: Joints last commanded [rad], shape (6,); None: nothing is.
        measured: Joints of the newest sample; NaN before the first.
        rest: Time [s] since what is commanded came to rest; 0 while it moves.

    Raises:
        NotReadyError: Neither is known.
    """
    if command is not None and (rest < _SETTLING or np.abs(measured - command).max() <= _ASTRAY):
        return command
    if not np.isfinite(measured).all():
        raise NotReadyError("no state from the controller yet; check host, port and udp_port")
    return measured
