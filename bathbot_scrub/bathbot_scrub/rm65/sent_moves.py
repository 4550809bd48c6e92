"""Motions that a program sends one by one: to joint angles, to a pose, along a line, or as a stream.

They go through free air as an approach does: planned and checked before anything moves, jerk-limited, and
under the force guard's limit for free air.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.control_loop import ControlLoop
from bathbot_scrub.rm65.errors import ArmError, CanceledError, NotReadyError
from bathbot_scrub.rm65.force_limits import ForceLimits
from bathbot_scrub.rm65.guard_states import State
from bathbot_scrub.rm65.inverse_kinematics import nearest, solve_head
from bathbot_scrub.rm65.joint_path import JointPath
from bathbot_scrub.rm65.kinematics import T_FLANGE_HEAD
from bathbot_scrub.rm65.motion import Planner, line_pace
from bathbot_scrub.rm65.motion_kind import Kind
from bathbot_scrub.rm65.path_runner import Pace
from bathbot_scrub.rm65.streamed_path import StreamedPath

Array = NDArray[np.float64]
LINE_SPEED, LINE_ACCELERATION = 0.10, 0.3  # [m/s], [m/s^2] of a line at full speed
SILENCE = 0.2  # [s] without a frame after which a stream is over
_POLL = 0.1  # [s] between looks at a motion that somebody waits for
_SAID = "a program moves the arm"


class SentMoves:
    """Begins motions; one at a time, refused while the arm does anything else."""

    def __init__(self, loop: ControlLoop, planner: Planner, limits: ForceLimits) -> None:
        """Work with these parts of a driver."""
        self._loop, self._planner, self._limits = loop, planner, limits
        self._stream: StreamedPath | None = None
        self._last_frame = 0.0

    def to_joints(self, goal: ArrayLike, share: float) -> None:
        """Go straight in joint space to `goal` [rad], shape (6,), at a share of the joints' pace, 0..1.

        Returns when the motion has ended.

        Raises:
            JointLimitError, CollisionError: Refused before any motion.
            NotReadyError: The arm does something else.
            CanceledError: It was stopped on the way.
        """
        path = self._planner.joint_path(self._loop.standing(), goal)
        pace = self._planner.joint_pace
        self._run(path, Pace(share * pace.speed, pace.acceleration, pace.jerk), Kind.SENT)

    def to_pose(self, T_base_flange: Array, share: float) -> None:
        """Go to a pose of the flange, (4, 4), straight in joint space; as `to_joints`.

        Raises:
            UnreachableError: Out of reach or beyond a joint's limit.
        """
        self.to_joints(self._nearest(T_base_flange, self._loop.standing()), share)

    def along_line(self, T_base_flange: Array, share: float) -> None:
        """Go to a pose of the flange, (4, 4), straight in space, at a share of 0.1 m/s; as `to_joints`.

        Raises:
            UnreachableError: Out of reach, beyond a joint's limit, or through a singularity.
        """
        start, speed = self._loop.standing(), share * LINE_SPEED
        ends = np.stack([self._planner.kinematics.head(start), T_base_flange @ T_FLANGE_HEAD])
        path = self._planner.tool_path(start, ends, speed)
        self._run(path, line_pace(speed, LINE_ACCELERATION), Kind.SENT_LINE)

    def stream(self, goal: ArrayLike, now: float) -> None:
        """Follow one frame of a stream of joint angles [rad], shape (6,), that came at `now` [s].

        The arm trails the frames by the way it needs to stop, and stands at the last one.

        Raises:
            JointLimitError, CollisionError: The frame is not followed.
            NotReadyError: The arm does something else, the frame is too far from the one before, or the
                stream was stopped: it must fall silent before it may begin again.
        """
        stream, self._last_frame = self._stream, now
        if stream is not None and not self._following():
            raise NotReadyError(
                f"the stream was given up: {self._loop.guard.reason or 'stopped'}; pause it for {SILENCE} s, "
                "then begin again where the arm stands"
            )
        begun = StreamedPath(self._loop.standing(), self._planner) if stream is None else stream
        path, cut = begun.extend(goal, 0.0 if stream is None else self._length())
        with self._loop.lock:
            if stream is None:
                self._loop.guard.begin_approach(self._limits.gentlest(), _SAID)
                self._loop.begin(path, self._planner.joint_pace, Kind.STREAM)
            else:
                self._loop.retarget(path, cut)
        self._stream = begun

    def stream_pose(self, T_base_flange: Array, now: float) -> None:
        """Follow one frame of a stream of flange poses, (4, 4); as `stream`.

        Raises:
            UnreachableError: Out of reach or beyond a joint's limit.
        """
        seed = self._loop.standing() if self._stream is None else self._stream.end
        self.stream(self._nearest(T_base_flange, seed), now)

    def tick(self, now: float) -> None:
        """End a stream that has fallen silent; call it now and then."""
        with self._loop.lock:
            over = now - self._last_frame > SILENCE and not self._loop.guard.moving
            if self._stream is not None and over:
                if self._following():
                    self._loop.arrive("the stream of joints is over")
                self._stream = None

    def _nearest(self, T_base_flange: Array, seed: Array) -> Array:
        solutions = solve_head(
            self._planner.kinematics, T_base_flange @ T_FLANGE_HEAD, self._planner.limits
        )
        return nearest(solutions, seed, self._planner.limits)

    def _following(self) -> bool:
        """Whether a stream is being followed still."""
        loop = self._loop
        return loop.kind is Kind.STREAM and loop.runner is not None and loop.guard.state is State.APPROACH

    def _length(self) -> float:
        runner = self._loop.runner
        if runner is None:
            raise NotReadyError("the stream was given up; begin again")
        return runner.length

    def _run(self, path: JointPath, pace: Pace, kind: Kind) -> None:
        self._planner.check(path.joints)
        loop = self._loop
        with loop.lock:
            loop.guard.begin_approach(self._limits.gentlest(), _SAID)
            loop.begin(path, pace, kind)
            while loop.guard.moving or loop.guard.paused:
                loop.lock.wait(_POLL)
            if loop.guard.state is not State.FREE:
                raise self._why()

    def _why(self) -> ArmError:
        guard = self._loop.guard
        return CanceledError(f"the move ended in {guard.state.name}: {guard.reason or 'stopped'}")
