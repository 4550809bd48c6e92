"""Motions that a program sends one by one: to joint angles, to a pose, along a line, or as a stream.

They go through free air as an approach does: planned and checked before anything moves, jerk-limited, and
under the force guard's limit for free air.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.arm.errors import ArmError, CanceledError, NotReadyError
from bathbot_scrub.arm.force_limits import ForceLimits
from bathbot_scrub.arm.states import State
from bathbot_scrub.arm.tool_path import densify, solve_path
from bathbot_scrub.rm65.arm.inverse_kinematics import check_poses
from bathbot_scrub.rm65.motion.commanded_motion import MotionKind
from bathbot_scrub.rm65.motion.control_loop import ControlLoop
from bathbot_scrub.rm65.motion.streamed_path import StreamedPath
from bathbot_scrub.rm65.paths.joint_path import JointPath, timed_path
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner
from bathbot_scrub.rm65.paths.path_runner import Pace

Array = NDArray[np.float64]
LINE_SPEED = 0.10  # [m/s] of the head along a line at full speed
SILENCE = 0.2  # [s] without a frame after which a stream is over
_POLL = 0.1  # [s] between looks at a motion that somebody waits for
_SAID = "a program moves the arm"


class ProgramMoves:
    """Begins motions; one at a time, refused while the arm does anything else."""

    def __init__(self, loop: ControlLoop, planner: MotionPlanner, limits: ForceLimits) -> None:
        """Work with these parts of a driver."""
        self._loop, self._planner, self._limits = loop, planner, limits
        self._stream: StreamedPath | None = None
        self._last_frame = 0.0
        self._stopped = False  # since the frames last fell silent

    def to_joints(self, goal: ArrayLike, share: float) -> None:
        """Go straight in joint space to `goal` [rad], shape (6,), at a share of the joints' pace, 0..1.

        Returns when the motion has ended.

        Raises:
            JointLimitError, CollisionError: Refused before any motion.
            NotReadyError: The arm does something else.
            CanceledError: It was stopped on the way.
        """
        path = self._planner.slow_near_people(self._planner.joint_path(self._loop.standing(), goal))
        pace = self._planner.joint_pace
        self._run(path, Pace(share * pace.speed, pace.acceleration, pace.jerk))

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
        planner, start = self._planner, self._loop.standing()
        goal = check_poses(T_base_flange) @ planner.arm.tool.T_flange_head
        ends = np.stack([planner.arm.head(start), goal])
        distances, poses = densify(ends)
        if len(distances) > 1:
            joints = solve_path(planner.arm, poses, start, planner.limits)
            self._run(_joint_path(distances, joints, share * LINE_SPEED, planner), planner.joint_pace)

    def stream(self, goal: ArrayLike, now: float) -> None:
        """Follow one frame of a stream of joint angles [rad], shape (6,), that came at `now` [s].

        The arm trails the frames by the way it needs to stop, and stands at the last one.

        Raises:
            JointLimitError, CollisionError: The frame is not followed.
            NotReadyError: The arm does something else, the frame is too far from the one before, or the
                stream was stopped: it must fall silent before it may begin again.
        """
        self.tick(now)
        with self._loop.lock:
            stream, self._last_frame = self._stream, now
            self._check_stream()
        begun = StreamedPath(self._loop.standing(), self._planner) if stream is None else stream
        path, cut = begun.extend(goal, 0.0 if stream is None else self._length())
        with self._loop.lock:
            self._check_stream()  # a stop may have come meanwhile
            if stream is None:
                self._loop.guard.begin_approach(self._limits.gentlest(), _SAID)
                self._loop.begin(path, self._planner.joint_pace, MotionKind.STREAM)
            else:
                self._loop.motion.retarget(path, cut)
                self._loop.moving = True
        self._stream = begun

    def stream_pose(self, T_base_flange: Array, now: float) -> None:
        """Follow one frame of a stream of flange poses, (4, 4); as `stream`.

        Raises:
            UnreachableError: Out of reach or beyond a joint's limit.
        """
        stream = self._stream
        seed = self._loop.standing() if stream is None else stream.end
        self.stream(self._nearest(T_base_flange, seed), now)

    def give_up(self, now: float) -> None:
        """Let no frame on its way after a stop at `now` [s] move the arm; the caller holds the lock."""
        self._last_frame, self._stopped = now, True

    def tick(self, now: float) -> None:
        """End a stream that has fallen silent; call it now and then."""
        with self._loop.lock:
            over = now - self._last_frame > SILENCE and not self._loop.moving
            if self._stream is not None and over:
                if self._follows_stream():
                    self._loop.motion.stand()
                    self._loop.guard.arrived("the stream of joints is over")
                self._stream = None
            self._stopped = self._stopped and not over

    def _check_stream(self) -> None:
        """Refuse frames behind a stop, or behind anything else that ended their stream."""
        if self._stopped or (self._stream is not None and not self._follows_stream()):
            raise NotReadyError(
                f"the stream was given up: {self._loop.guard.reason or 'stopped'}; pause it for {SILENCE} s, "
                "then begin again where the arm stands"
            )

    def _nearest(self, T_base_flange: Array, seed: Array) -> Array:
        arm = self._planner.arm
        solutions = arm.solve_head(T_base_flange @ arm.tool.T_flange_head, arm.limits)
        return nearest(solutions, seed, arm.limits)

    def _follows_stream(self) -> bool:
        """Whether a stream is being followed still."""
        loop = self._loop
        motion, state = loop.motion, loop.guard.state
        return motion.kind is MotionKind.STREAM and motion.runner is not None and state is State.APPROACH

    def _length(self) -> float:
        runner = self._loop.motion.runner
        if runner is None:
            raise NotReadyError("the stream was given up; begin again")
        return runner.length

    def _run(self, path: JointPath, pace: Pace) -> None:
        self._planner.check(path.joints)
        loop = self._loop
        with loop.lock:
            loop.guard.begin_approach(self._limits.gentlest(), _SAID)
            loop.begin(path, pace, MotionKind.PROGRAM)
            while loop.moving or loop.guard.paused or loop.guard.waiting:
                loop.lock.wait(_POLL)
            if loop.guard.state is not State.FREE:
                raise self._why()

    def _why(self) -> ArmError:
        guard = self._loop.guard
        return CanceledError(f"the move ended in {guard.state.name}: {guard.reason or 'stopped'}")


def _joint_path(distances: Array, joints: Array, speed: float, planner: MotionPlanner) -> JointPath:
    """A way of the head as a path in joint space, so that it ends, brakes and turns back as those do.

    Args:
        distances: Of the head [m], shape (N,), strictly rising.
        joints: [rad], shape (N, 6).
        speed: Of the head, at most [m/s].
        planner: With the pace and the limits of the joints.
    """
    steps = np.abs(np.diff(joints, axis=0)).max(-1)
    caps = speed * steps / np.diff(distances)
    caps = np.minimum(np.append(caps, caps[-1]), np.insert(caps, 0, caps[0]))
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    path = timed_path(lengths, joints, planner.joint_pace.acceleration, planner.limits, 1.0, caps)
    return planner.slow_near_people(path, caps)
