"""Between ROS messages and what this package computes with: the one place where they meet.

Surfaces, contact targets and poses are read by `bathbot_localize.messages`.
"""

import numpy as np
from bathbot_depthcorr.ros.messages import stamp_from_seconds, stamp_seconds
from bathbot_localize.messages import pose_from_transform, transform_from_pose
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from bathbot_msgs.action import Scrub
from bathbot_msgs.msg import ArmState, ContactTargets, ScrubSegment
from bathbot_scrub.errors import NotReadyError
from bathbot_scrub.path.segments import Segment
from bathbot_scrub.rm65.arm.kinematics import JOINT_NAMES
from bathbot_scrub.rm65.guard.states import State
from bathbot_scrub.scrub_job import ArmReport, Outcome

Array = NDArray[np.float64]
BASE = "base_link"


def header_at(stamp: float) -> Header:
    """Header of the base frame at a time [s]."""
    return Header(frame_id=BASE, stamp=stamp_from_seconds(stamp))


def joints_from_state(message: JointState) -> Array:
    """Joint angles [rad], shape (6,), in the order of the arm.

    Raises:
        NotReadyError: When a joint is missing.
    """
    angles = dict(zip(message.name, message.position, strict=False))
    if not set(JOINT_NAMES) <= set(angles):
        named, needed = ", ".join(message.name), ", ".join(JOINT_NAMES)
        raise NotReadyError(f"joint_states names {named}; needed are {needed}; is that of another arm?")
    return np.array([angles[name] for name in JOINT_NAMES])


def targets_by_region(message: ContactTargets) -> dict[str, Array]:
    """Region -> T_base_target, shape (4, 4), of all contact targets."""
    return {target.region: transform_from_pose(target.pose.pose) for target in message.targets}


def message_from_segment(
    segment: Segment, path_id: int, region: str, spacing: float, speed: float
) -> ScrubSegment:
    """The message of a segment; spacing [m] and speed [m/s] along the path."""
    return ScrubSegment(
        header=header_at(segment.stamp), path_id=path_id, index=segment.index, last=segment.last,
        region=region, poses=[pose_from_transform(pose) for pose in segment.poses],
        spacing=spacing, speed=speed,
    )  # fmt: skip


def segment_from_message(message: ScrubSegment) -> Segment:
    """The segment of a message; path, region, spacing and speed stay with the message."""
    poses = np.array([transform_from_pose(pose) for pose in message.poses]).reshape(-1, 4, 4)
    return Segment(message.index, message.last, poses, stamp_seconds(message.header.stamp))


def path_from_poses(poses: Array, stamp: float) -> Path:
    """A nav_msgs/Path of head poses, shape (N, 4, 4), in the base frame."""
    header = header_at(stamp)
    stamped = [PoseStamped(header=header, pose=pose_from_transform(pose)) for pose in poses]
    return Path(header=header, poses=stamped)


def report_from_arm(message: ArmState) -> ArmReport:
    """What the arm says of itself."""
    return ArmReport(
        State(message.state), message.reason, message.path_id, message.segment_index,
        message.segments_queued, message.distance_along, message.path_done,
    )  # fmt: skip


def result_from_outcome(outcome: Outcome) -> Scrub.Result:
    """The action's result of how a scrub ended."""
    return Scrub.Result(
        error_code=int(outcome.code), error_msg=outcome.message,
        segments=outcome.segments, length=outcome.length,
    )  # fmt: skip
