"""Between the arm's arrays and ROS messages; the only place of this package part that knows both."""

from collections.abc import Sequence

import numpy as np
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.geometry.rigid import inverse
from bathbot_depthcorr.ros.pose_decoding import pose_values, transforms_from_poses
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from bathbot_localize.messages import (
    MessageError,
    messages_from_transforms,
    pose_from_transform,
    surface_from_cloud,
)
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Pose, PoseStamped, TransformStamped, WrenchStamped
from numpy.typing import NDArray
from sensor_msgs.msg import JointState, PointCloud2
from tf2_msgs.msg import TFMessage

from bathbot_msgs.action import Approach
from bathbot_msgs.msg import ArmState, ScrubSegment
from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.errors import (
    ArmSettingsError,
    CanceledError,
    ForceLimitError,
    InvalidPoseError,
    JointLimitError,
    NoContactError,
    UnreachableError,
)
from bathbot_scrub.rm65.arm.kinematics import JOINT_NAMES
from bathbot_scrub.rm65.driver import Snapshot
from bathbot_scrub.rm65.motion.approach import Request, Touch
from bathbot_scrub.rm65.timing.clock import MONOTONIC
from bathbot_scrub.segment.messages import BASE, segment_from_message
from bathbot_scrub.segment.segment import MOST_POSES, Segment

Array = NDArray[np.float64]
HEAD = SCRUB_HEAD.frame

_ERROR_CODES = (
    (InvalidPoseError, Approach.Result.INVALID_TARGET),
    (ArmSettingsError, Approach.Result.INVALID_TARGET),
    (UnreachableError, Approach.Result.UNREACHABLE),
    (JointLimitError, Approach.Result.UNREACHABLE),
    (NoContactError, Approach.Result.NO_CONTACT),
    (ForceLimitError, Approach.Result.FORCE_LIMIT),
    (CanceledError, Approach.Result.CANCELED),
)


def error_code(error: BathbotError) -> int:
    """The action's code of an error."""
    return next((code for kind, code in _ERROR_CODES if isinstance(error, kind)), Approach.Result.NOT_READY)


def approach_result(outcome: Touch | BathbotError, stamp: Time) -> Approach.Result:
    """The action's result of an approach that ended in contact or by an error."""
    if isinstance(outcome, BathbotError):
        return Approach.Result(error_code=error_code(outcome), error_msg=str(outcome))
    return Approach.Result(contact=pose_stamped(outcome.T_base_head, stamp), force=outcome.force)


def stamp_of(instant: float, now: Time) -> Time:
    """ROS time of an instant of the driver's clock [s], given ROS time now."""
    nanoseconds = now.sec * 10**9 + now.nanosec - round((MONOTONIC() - instant) * 1e9)
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def checked_transforms(poses: Sequence[Pose]) -> Array:
    """Poses as transforms, shape (N, 4, 4).

    Raises:
        InvalidPoseError: When one is not finite or its quaternion is not of unit length to 1e-3.
    """
    values = pose_values(poses)
    norms = np.linalg.norm(values[:, 3:], axis=1)
    good = np.isfinite(values).all(1) & (np.abs(norms - 1.0) < 1e-3)
    if not good.all():
        index = int(np.argmin(good))
        raise InvalidPoseError(
            f"pose {index} is not finite or its quaternion has length {norms[index]:.4f}, not 1"
        )
    return transforms_from_poses(poses)


def request_from_goal(goal: Approach.Goal) -> Request:
    """What an approach is asked for.

    Raises:
        InvalidPoseError: Not finite, not a unit quaternion, or in another frame.
    """
    _check_frame(goal.target.header.frame_id, "the target")
    return Request(checked_transforms([goal.target.pose])[0], goal.region, goal.standoff, goal.speed)


def checked_segment(message: ScrubSegment) -> Segment:
    """A segment to follow.

    Raises:
        InvalidPoseError: Too many poses, not finite, not unit quaternions, or in another frame.
    """
    _check_frame(message.header.frame_id, f"segment {message.index}")
    if len(message.poses) > MOST_POSES:
        raise InvalidPoseError(f"it holds {len(message.poses)} poses; the most is {MOST_POSES}")
    checked_transforms(message.poses)
    return segment_from_message(message)


def body_from_cloud(message: PointCloud2, now: float) -> tuple[Array, float]:
    """Points of a body cloud, shape (N, 3) [m], and the time of its picture on the driver's clock [s].

    Args:
        message: The cloud.
        now: ROS time [s].

    Raises:
        InvalidPoseError: In another frame, or no points in it.
    """
    _check_frame(message.header.frame_id, "the body cloud")
    try:
        points = surface_from_cloud(message).reshape(-1, 3)
    except MessageError as error:
        raise InvalidPoseError(f"the body cloud cannot be read: {error}") from error
    age = max(now - message.header.stamp.sec - 1e-9 * message.header.stamp.nanosec, 0.0)
    return points[np.isfinite(points).all(axis=1)], MONOTONIC() - age


def _check_frame(frame: str, what: str) -> None:
    if frame.lstrip("/") != BASE:
        raise InvalidPoseError(f"{what} is in frame {frame!r}; it must be in {BASE}")


def joint_state_message(joints: Array, stamp: Time) -> JointState:
    """Joint angles [rad] as JointState."""
    message = JointState(name=list(JOINT_NAMES), position=[float(q) for q in joints])
    message.header.stamp, message.header.frame_id = stamp, BASE
    return message


def wrench_message(wrench: Array, stamp: Time) -> WrenchStamped:
    """A wrench about the head's tip, axes of the head."""
    message = WrenchStamped()
    message.header.stamp, message.header.frame_id = stamp, HEAD
    force, torque = message.wrench.force, message.wrench.torque
    force.x, force.y, force.z, torque.x, torque.y, torque.z = (float(v) for v in wrench)
    return message


def pose_stamped(T: Array, stamp: Time) -> PoseStamped:
    """A pose of the head in the base frame."""
    message = PoseStamped(pose=pose_from_transform(T))
    message.header.stamp, message.header.frame_id = stamp, BASE
    return message


def tree_message(arm: Arm, joints: Array, stamp: Time) -> TFMessage:
    """Transforms base_link -> Link1 -> ... -> Link6 -> scrub_head."""
    frames = arm.link_frames(joints)
    steps = np.concatenate([inverse(frames[:-1]) @ frames[1:], arm.tool.T_flange_head[None]])
    names = (*arm.link_names, arm.tool.frame)
    transforms = []
    for parent, child, step in zip(names, names[1:], messages_from_transforms(steps), strict=False):
        message = TransformStamped(child_frame_id=child, transform=step)
        message.header.stamp, message.header.frame_id = stamp, parent
        transforms.append(message)
    return TFMessage(transforms=transforms)


def arm_state_message(snapshot: Snapshot, stamp: Time) -> ArmState:
    """What the driver does now."""
    message = ArmState(
        state=int(snapshot.state),
        reason=snapshot.reason,
        connected=snapshot.connected,
        path_id=snapshot.path_id,
        segment_index=snapshot.segment_index,
        segments_queued=snapshot.segments_queued,
        distance_along=snapshot.distance_along,
        path_done=snapshot.path_done,
        force=snapshot.force,
        force_threshold=snapshot.force_threshold,
        period=snapshot.period,
        period_deviation_p99=snapshot.period_deviation_p99,
    )
    message.header.stamp, message.header.frame_id = stamp, BASE
    return message
