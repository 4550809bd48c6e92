"""Between ROS messages and what the planner computes with.

Surfaces and contact targets are read by `bathbot_localize.messages`, segments by `segment.messages`.
"""

from collections.abc import Sequence
from functools import partial

import numpy as np
from bathbot_depthcorr.ros.image_decoding import stamp_seconds
from bathbot_depthcorr.ros.pose_decoding import transform_from_pose
from bathbot_localize.messages import poses_from_transforms, surface_from_cloud
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from sensor_msgs.msg import JointState, PointCloud2

from bathbot_msgs.action import Scrub
from bathbot_msgs.msg import ArmState, ContactTargets
from bathbot_scrub.arm.states import State
from bathbot_scrub.errors import NotReadyError
from bathbot_scrub.job.scrub_job import ArmReport, Outcome
from bathbot_scrub.path.surface_map import Sighting
from bathbot_scrub.segment.messages import header_at

Array = NDArray[np.float64]


def joints_from_state(message: JointState, joint_names: Sequence[str]) -> Array:
    """Joint angles [rad], shape (J,), in the order of the names of an arm's joints.

    Raises:
        NotReadyError: When a joint is missing.
    """
    angles = dict(zip(message.name, message.position, strict=False))
    if not set(joint_names) <= set(angles):
        named, needed = ", ".join(message.name), ", ".join(joint_names)
        raise NotReadyError(f"joint_states names {named}; needed are {needed}; is that of another arm?")
    return np.array([angles[name] for name in joint_names])


def sighting_from_cloud(message: PointCloud2) -> Sighting:
    """A surface, or a body, not decoded yet."""
    return Sighting(stamp_seconds(message.header.stamp), partial(surface_from_cloud, message))


def targets_by_region(message: ContactTargets) -> dict[str, Array]:
    """Region -> T_base_target, shape (4, 4), of all contact targets."""
    return {target.region: transform_from_pose(target.pose.pose) for target in message.targets}


def path_from_poses(poses: Array, stamp: float) -> Path:
    """A nav_msgs/Path of head poses, shape (N, 4, 4), in the base frame."""
    header = header_at(stamp)
    stamped = [PoseStamped(header=header, pose=pose) for pose in poses_from_transforms(poses)]
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
