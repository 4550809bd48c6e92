"""Between ROS messages and the arrays of this package: the one place where they meet.

Images, camera_info, extrinsics and poses are read by `bathbot_depthcorr.ros`.
"""

import array
from typing import Any, NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.rigid import quaternion_from_rotation
from bathbot_depthcorr.ros.pose_decoding import transform_from_message, transform_from_pose
from geometry_msgs.msg import Pose, Transform, TransformStamped
from numpy.typing import ArrayLike, NDArray
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import BoundingBox2D, Detection2D, Detection2DArray, ObjectHypothesisWithPose

from bathbot_localize.errors import LocalizeError
from bathbot_localize.regions import SkinRegion
from bathbot_localize.target.target import Target
from bathbot_msgs.msg import ContactTarget, ContactTargets

Array = NDArray[np.float64]
_XYZ = [PointField(name=n, offset=4 * i, datatype=PointField.FLOAT32, count=1) for i, n in enumerate("xyz")]


class MessageError(LocalizeError):
    """A message whose content this package cannot read."""


class StampedTransform(NamedTuple):
    """One entry of /tf: `transform`, shape (4, 4), maps coordinates of `child` to those of `parent`."""

    parent: str
    child: str
    stamp: float
    transform: Array


def poses_from_transforms(transforms: ArrayLike) -> list[Pose]:
    """A geometry_msgs/Pose of each transform, shape (N, 4, 4)."""
    transforms = np.asarray(transforms, dtype=float)
    quaternions = quaternion_from_rotation(transforms[:, :3, :3])
    poses = []
    for place, quaternion in zip(transforms[:, :3, 3].tolist(), quaternions.tolist(), strict=True):
        pose = Pose()
        p, o = pose.position, pose.orientation
        p.x, p.y, p.z = place
        o.x, o.y, o.z, o.w = quaternion
        poses.append(pose)
    return poses


def pose_from_transform(transform: ArrayLike) -> Pose:
    """A geometry_msgs/Pose of a transform, shape (4, 4)."""
    return poses_from_transforms(np.asarray(transform)[None])[0]


def messages_from_transforms(transforms: ArrayLike) -> list[Transform]:
    """A geometry_msgs/Transform of each transform, shape (N, 4, 4)."""
    messages = []
    for pose in poses_from_transforms(transforms):
        message, p = Transform(rotation=pose.orientation), pose.position
        message.translation.x, message.translation.y, message.translation.z = p.x, p.y, p.z
        messages.append(message)
    return messages


def message_from_transform(transform: ArrayLike) -> Transform:
    """A geometry_msgs/Transform of a transform, shape (4, 4)."""
    return messages_from_transforms(np.asarray(transform)[None])[0]


def transforms_from_tf(message: TFMessage) -> list[StampedTransform]:
    """All transforms of a message of /tf or /tf_static, stamps in [s]."""
    return [
        StampedTransform(
            entry.header.frame_id.lstrip("/"),
            entry.child_frame_id.lstrip("/"),
            entry.header.stamp.sec + 1e-9 * entry.header.stamp.nanosec,
            transform_from_message(entry.transform),
        )
        for entry in message.transforms
    ]


def stamped_from_transform(transform: ArrayLike, header: Header, child: str) -> TransformStamped:
    """A TransformStamped from `child` to the header's frame."""
    return TransformStamped(header=header, child_frame_id=child, transform=message_from_transform(transform))


def cloud_from_surface(points: ArrayLike, header: Header) -> PointCloud2:
    """Organised cloud of points [m], shape (H, W, 3), NaN where unknown, in the header's frame."""
    points = np.ascontiguousarray(points, dtype="<f4")
    height, width = points.shape[:2]
    message = PointCloud2(
        header=header, height=height, width=width, fields=_XYZ, is_bigendian=False,
        point_step=12, row_step=12 * width, is_dense=False,
    )  # fmt: skip
    if points.size:
        data = array.array("B")
        data.frombytes(memoryview(points).cast("B"))
        message.data = data  # the setter takes an array.array as it is, without a copy
    return message


def surface_from_cloud(message: PointCloud2) -> Array:
    """Points [m], shape (H, W, 3), NaN where unknown, of an organised cloud with float32 x, y, z.

    Raises:
        MessageError: When a coordinate is missing, not float32, or the data is short.
    """
    offsets = {field.name: field.offset for field in message.fields if field.datatype == PointField.FLOAT32}
    data = np.frombuffer(message.data, np.uint8)
    if not {"x", "y", "z"} <= set(offsets) or data.size < message.height * message.row_step:
        raise MessageError(
            f"cloud of {message.width}x{message.height} with float32 fields {sorted(offsets)} "
            f"and {data.size} bytes is no organised surface; is the topic that of target_localizer?"
        )
    kind = np.dtype({
        "names": ["x", "y", "z"], "formats": [">f4" if message.is_bigendian else "<f4"] * 3,
        "offsets": [offsets[name] for name in "xyz"], "itemsize": message.point_step,
    })  # fmt: skip
    rows = data[: message.height * message.row_step].reshape(message.height, message.row_step)
    points = np.ascontiguousarray(rows[:, : message.width * message.point_step]).view(kind)
    return np.stack([points[name] for name in "xyz"], axis=-1).astype(np.float64)


def regions_from_detections(message: Detection2DArray) -> list[SkinRegion]:
    """Regions of a detector's message, each with its best class; those without any are left out."""
    regions = []
    for detection in message.detections:
        if not detection.results:
            continue
        best = max((result.hypothesis for result in detection.results), key=lambda guess: guess.score)
        centre, half = (
            detection.bbox.center.position,
            (detection.bbox.size_x / 2.0, detection.bbox.size_y / 2.0),
        )
        box = (centre.x - half[0], centre.y - half[1], centre.x + half[0], centre.y + half[1])
        regions.append(SkinRegion(best.class_id, best.score, box))
    return regions


def detections_from_regions(regions: list[SkinRegion], header: Header) -> Detection2DArray:
    """The inverse of `regions_from_detections`."""
    message = Detection2DArray(header=header)
    for region in regions:
        left, top, right, bottom = region.box
        result = ObjectHypothesisWithPose()
        result.hypothesis.class_id, result.hypothesis.score = region.name, float(region.score)
        box = BoundingBox2D(size_x=float(right - left), size_y=float(bottom - top))
        box.center.position.x, box.center.position.y = (left + right) / 2.0, (top + bottom) / 2.0
        message.detections.append(Detection2D(header=header, results=[result], bbox=box))
    return message


def contact_targets_from(targets: list[Target], header: Header) -> ContactTargets:
    """The message of targets in the base frame; the header's stamp is that of the colour image."""
    message = ContactTargets(header=header)
    for target in targets:
        entry: Any = ContactTarget(
            region=target.region, score=float(target.score), pixel=np.asarray(target.pixel, dtype=float),
            radius_px=float(target.radius_px), points=int(target.points),
        )  # fmt: skip
        entry.pose.pose = pose_from_transform(target.T_base_target)
        entry.pose.covariance = np.asarray(target.covariance, dtype=float).ravel()
        message.targets.append(entry)
    return message


def targets_from_contact(message: ContactTargets) -> list[Target]:
    """The inverse of `contact_targets_from`."""
    return [
        Target(
            entry.region, entry.score, transform_from_pose(entry.pose.pose),
            np.reshape(entry.pose.covariance, (6, 6)).astype(float), tuple(map(float, entry.pixel)),
            entry.radius_px, entry.points,
        )
        for entry in message.targets
    ]  # fmt: skip
