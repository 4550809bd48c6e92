"""What `sim_camera` publishes, on the topics of realsense2_camera."""

import numpy as np
from bathbot_depthcorr.node.endpoints_node import LATCHED, EndpointOwner
from bathbot_depthcorr.ros.messages import (
    extrinsics_from_transform,
    image_from_colour,
    image_mm_from_depth,
    info_from_pinhole,
    stamp_from_seconds,
)
from bathbot_localize.messages import message_from_transform
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import TransformStamped
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from bathbot_bringup.sim.camera.d455_camera import Shot, camera_frames
from bathbot_bringup.sim.camera.d455_unit import D455Unit

CAMERA = "camera/camera"
COLOUR_FRAME, DEPTH_FRAME = "camera_color_optical_frame", "camera_depth_optical_frame"


class SimCameraOutput:
    """Encodes what one unit shows and says; times are ROS times [s]."""

    def __init__(self, node: EndpointOwner, unit: D455Unit) -> None:
        """Advertise the topics."""
        self._name, self._unit = node.get_name(), unit
        self._colour = node.publisher(Image, f"{CAMERA}/color/image_raw", 5)
        self._colour_info = node.publisher(CameraInfo, f"{CAMERA}/color/camera_info", 5)
        self._depth = node.publisher(Image, f"{CAMERA}/depth/image_rect_raw", 5)
        self._depth_info = node.publisher(CameraInfo, f"{CAMERA}/depth/camera_info", 5)
        self._extrinsics = node.publisher(Extrinsics, f"{CAMERA}/extrinsics/depth_to_color", LATCHED)
        self._static = node.publisher(TFMessage, "/tf_static", LATCHED)
        self._temperatures = node.publisher(DiagnosticArray, "/diagnostics", 10)

    def publish_unit(self, now: float) -> None:
        """Send what stays: the factory's extrinsics and the frames of the camera."""
        self._extrinsics.publish(extrinsics_from_transform(self._unit.published_T_colour_depth))
        frames = camera_frames(self._unit)
        self._static.publish(TFMessage(transforms=[_transform(*frame, now) for frame in frames]))

    def publish(self, shot: Shot, now: float) -> None:
        """Send one pair of pictures that show the moment `now`."""
        stamp, unit = stamp_from_seconds(now), self._unit
        colour, depth = Header(stamp=stamp, frame_id=COLOUR_FRAME), Header(stamp=stamp, frame_id=DEPTH_FRAME)
        self._depth_info.publish(info_from_pinhole(unit.published_depth, depth))
        self._depth.publish(image_mm_from_depth(shot.depth, depth))
        self._colour_info.publish(info_from_pinhole(unit.published_colour, colour))
        self._colour.publish(image_from_colour(shot.colour, colour))

    def publish_temperature(self, celsius: float, now: float) -> None:
        """Send serial number and temperature [deg C] as the real driver tells them."""
        status = DiagnosticStatus(
            level=DiagnosticStatus.OK,
            name=f"{self._name}: Temperatures",
            hardware_id=self._unit.serial,
            message="OK",
            values=[KeyValue(key="Asic Temperature", value=f"{celsius:.1f}")],
        )
        header = Header(stamp=stamp_from_seconds(now))
        self._temperatures.publish(DiagnosticArray(header=header, status=[status]))


def _transform(parent: str, child: str, transform: np.ndarray, now: float) -> TransformStamped:
    header = Header(stamp=stamp_from_seconds(now), frame_id=parent)
    return TransformStamped(header=header, child_frame_id=child, transform=message_from_transform(transform))
