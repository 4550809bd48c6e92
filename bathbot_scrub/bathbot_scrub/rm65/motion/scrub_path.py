"""The scrub path as it arrives: segments in order, bounded, turned into one growing joint path."""

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.errors import InvalidPoseError, NotReadyError
from bathbot_scrub.arm.tool_path import densify, solve_path
from bathbot_scrub.rm65.arm.inverse_kinematics import check_poses
from bathbot_scrub.rm65.paths.joint_path import JointPath, timed_tool_path
from bathbot_scrub.rm65.paths.motion_planner import LINE_DECELERATION, MotionPlanner
from bathbot_scrub.segment.segment import Segment

Array = NDArray[np.float64]
_LARGEST_GAP = 0.05  # [m] between neighbouring poses of a path
_LEAD_IN_SPEED = 0.08  # [m/s] off the skin
_SET_DOWN_SPEED = 0.025  # [m/s]; well below the surge of the force limits


class ScrubPath:
    """The path being followed. Immutable but for `extend`, which only adds at the end."""

    def __init__(
        self, first: Segment, planner: MotionPlanner, joints: Array, lead_in: Array, top_speed: float
    ) -> None:
        """Begin with segment 0.

        Args:
            first: Its poses follow the lead-in.
            planner: Plans tool paths.
            joints: Joints now [rad], shape (6,), at the first pose of the lead-in.
            lead_in: Head poses from here to the first pose of the path, (M, 4, 4).
            top_speed: [m/s] that no segment exceeds.

        Raises:
            UnreachableError: When lead-in or segment cannot be reached, or something is in the way.
            InvalidPoseError: Not finite, not rigid, or too far apart.
            NotReadyError: When the path does not begin with index 0.
        """
        if first.index != 0:
            raise NotReadyError(
                f"path {first.path_id} begins with segment {first.index}; send segment 0 first"
            )
        self.path_id, self.region, self.finished = first.path_id, first.region, False
        self._planner, self._top_speed = planner, top_speed
        distances, dense = densify(check_poses(lead_in))
        self._joints = solve_path(planner.arm, dense, joints, planner.limits)
        planner.check_tool_path(self._joints, dense)
        last_piece = np.linalg.norm(lead_in[-1, :3, 3] - lead_in[-2, :3, 3])
        self._distances = distances
        self._caps = np.where(distances < distances[-1] - last_piece, _LEAD_IN_SPEED, _SET_DOWN_SPEED)
        self._last_pose = dense[-1]
        self._lead_in = float(distances[-1])
        self.ends: list[float] = []
        self.path = self.extend(first)

    def extend(self, segment: Segment) -> JointPath:
        """Add the next segment; give the whole path.

        Raises:
            UnreachableError, InvalidPoseError, NotReadyError: As on creation; nothing is added then.
        """
        if segment.path_id != self.path_id or segment.index != len(self.ends) or self.finished:
            raise NotReadyError(
                f"segment {segment.index} of path {segment.path_id} does not follow {len(self.ends) - 1} "
                f"of path {self.path_id}; send them in order"
            )
        if segment.region != self.region:
            raise NotReadyError(
                f"segment {segment.index} is of {segment.region}, path {self.path_id} of {self.region}; "
                "begin a new path for another region"
            )
        poses = check_poses(segment.T_base_heads)
        if poses.ndim != 3 or len(poses) < 1:
            raise InvalidPoseError(f"segment {segment.index} holds no poses")
        knots = np.concatenate([self._last_pose[None], poses])
        gaps = np.linalg.norm(np.diff(knots[:, :3, 3], axis=0), axis=1)
        if gaps.max() > _LARGEST_GAP:
            raise InvalidPoseError(
                f"segment {segment.index} has poses {gaps.max():.3f} m apart, the most is {_LARGEST_GAP} m"
            )
        if not 0.0 < segment.speed < np.inf:
            raise InvalidPoseError(f"segment {segment.index} asks for a speed of {segment.speed} m/s")
        distances, dense = densify(knots)
        if len(distances) > 1:
            joints = solve_path(self._planner.arm, dense, self._joints[-1], self._planner.limits)
            self._planner.check_tool_path(joints, dense)
            self._joints = np.concatenate([self._joints, joints[1:]])
            self._caps = np.concatenate(
                [self._caps, np.full(len(distances) - 1, min(segment.speed, self._top_speed))]
            )
            self._distances = np.concatenate([self._distances, self._distances[-1] + distances[1:]])
            self._last_pose = dense[-1]
        self.finished = segment.last
        distances, joints, caps = self._distances, self._joints, self._caps
        if len(distances) < 2:  # all poses are where the head is
            distances, joints, caps = np.array([0.0, 1e-6]), np.repeat(joints, 2, 0), np.repeat(caps, 2)
        self.path = timed_tool_path(
            distances, joints, LINE_DECELERATION, self._planner.limits, self._planner.joint_share, caps
        )
        self.ends.append(self.path.end)
        self._travel = self.path.lengths, distances  # at once: another thread asks `travelled_at`
        return self.path

    def travelled_at(self, length: float) -> float:
        """How far the head has come along the path without its lead-in [m]."""
        return max(float(np.interp(length, *self._travel)) - self._lead_in, 0.0)

    def segment_at(self, length: float) -> int:
        """Index of the segment under the head."""
        return min(int(np.searchsorted(self.ends, length - 1e-6)), len(self.ends) - 1)

    def queued_at(self, length: float) -> int:
        """Segments not yet followed to their end."""
        return len(self.ends) - int(np.searchsorted(self.ends, length + 1e-6, side="right"))
