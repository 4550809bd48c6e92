"""Between segments and bathbot_msgs/ScrubSegment."""

from bathbot_depthcorr.ros.messages import stamp_from_seconds, stamp_seconds
from bathbot_depthcorr.ros.pose_decoding import transforms_from_poses
from bathbot_localize.messages import poses_from_transforms
from std_msgs.msg import Header

from bathbot_msgs.msg import ScrubSegment
from bathbot_scrub.segment.segment import Segment

BASE = "base_link"  # the frame of all poses


def header_at(stamp: float) -> Header:
    """Header of the base frame at a time [s]."""
    return Header(frame_id=BASE, stamp=stamp_from_seconds(stamp))


def message_from_segment(segment: Segment) -> ScrubSegment:
    """The message of a segment."""
    return ScrubSegment(
        header=header_at(segment.stamp), path_id=segment.path_id, index=segment.index, last=segment.last,
        region=segment.region, poses=poses_from_transforms(segment.T_base_heads),
        spacing=segment.spacing, speed=segment.speed,
    )  # fmt: skip


def segment_from_message(message: ScrubSegment) -> Segment:
    """The segment of a message in the base frame; quaternions are brought to unit length."""
    return Segment(
        message.path_id, message.index, message.last, message.region, transforms_from_poses(message.poses),
        message.speed, message.spacing, stamp_seconds(message.header.stamp),
    )  # fmt: skip
