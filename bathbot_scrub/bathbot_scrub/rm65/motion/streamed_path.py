"""A joint path that grows frame by frame and forgets what lies behind."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.rm65.paths.joint_path import JointPath, joint_move, timed_path
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner

Array = NDArray[np.float64]
LARGEST_FRAME = np.radians(10.0)  # [rad] of a joint between frames, as the controller has it
KEPT = 1.0  # [rad] behind the arm: the way back when it meets something


class StreamedPath:
    """The frames of a stream of joints as one path; s is the travel of the fastest joint [rad]."""

    def __init__(self, start: ArrayLike, planner: MotionPlanner) -> None:
        """Begin at `start` [rad], shape (6,)."""
        self._planner = planner
        self._lengths, self._joints = np.zeros(1), np.asarray(start, dtype=float)[None]

    @property
    def end(self) -> Array:
        """Joints [rad], shape (6,), of the last frame."""
        return self._joints[-1]

    def extend(self, goal: ArrayLike, length: float) -> tuple[JointPath, float]:
        """Add a frame [rad], shape (6,); the arm is at `length` of the path.

        Returns:
            The path, and by how much [rad] lengths on it are less than before.

        Raises:
            NotReadyError: A joint would turn more than 10 degrees from one frame to the next.
            JointLimitError, CollisionError: The frame is left out.
        """
        planner = self._planner
        step = np.abs(np.asarray(goal, dtype=float) - self.end)
        if not step.max() <= LARGEST_FRAME:
            joint = int(np.argmax(step))
            raise NotReadyError(
                f"joint {joint + 1} turns {np.degrees(step[joint]):.1f} deg from one frame to the next, more "
                f"than {np.degrees(LARGEST_FRAME):.0f}; begin where the arm stands and send finer steps"
            )
        lengths, joints = joint_move(self.end, goal, limits=planner.limits)
        planner.check(joints)
        lengths = np.append(self._lengths, self._lengths[-1] + lengths[1:])
        joints = np.concatenate([self._joints, joints[1:]])
        first = max(int(np.searchsorted(lengths, length - KEPT)) - 1, 0)
        cut = float(lengths[first])
        self._lengths, self._joints = lengths[first:] - cut, joints[first:]
        path = timed_path(self._lengths, self._joints, planner.joint_pace.acceleration, planner.limits, 1.0)
        return planner.slow_near_people(path), cut
