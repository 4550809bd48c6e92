"""Hears a running camera for the coach: what describes it, and its pictures."""

import time
from typing import Any

from bathbot_depthcorr.calibration.live_views import LiveViews
from bathbot_depthcorr.node.stage_node import LATCHED
from bathbot_depthcorr.ros.camera_health import CameraHealth, camera_health
from bathbot_depthcorr.ros.messages import (
    colour_from_image,
    depth_from_image,
    stamp_seconds,
    transform_from_extrinsics,
)
from bathbot_depthcorr.views.bag_camera import (
    COLOUR,
    COLOUR_INFO,
    DEPTH,
    DEPTH_INFO,
    EXTRINSICS,
    camera_from_messages,
    refuse_other_size,
)
from bathbot_depthcorr.views.chessboard import Chessboard
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image

from bathbot_bringup.errors import InputError

_KINDS = {COLOUR_INFO: CameraInfo, DEPTH_INFO: CameraInfo, EXTRINSICS: Extrinsics}


class CameraListener:
    """Subscribes to one camera; keeps what describes it, and hands pictures on.

    Attributes:
        health: Serial number and temperature, as far as they were told.
        views: What takes the pictures; None until `begin`.
    """

    def __init__(self, node: Node, camera: str, patience: float) -> None:
        """Subscribe.

        Args:
            node: Of the graph.
            camera: Namespace of the camera's topics.
            patience: Longest time without a picture [s].
        """
        self._camera, self._patience = camera.strip("/"), patience
        self._seen: dict[str, Any] = {}
        self.health, self._heard = CameraHealth(), time.monotonic()
        self.views: LiveViews | None = None
        for name, kind in _KINDS.items():
            qos = LATCHED if name == EXTRINSICS else qos_profile_sensor_data
            node.create_subscription(kind, self._topic(name), self._keep(name), qos)
        node.create_subscription(Image, self._topic(COLOUR), self._take_colour, qos_profile_sensor_data)
        node.create_subscription(Image, self._topic(DEPTH), self._take_depth, qos_profile_sensor_data)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._diagnose, 10)

    def knows_camera(self) -> bool:
        """Whether all has come that describes the camera."""
        return not self.silent()

    def silent(self) -> list[str]:
        """Topics that describe the camera and have not been heard."""
        return [self._topic(name) for name in _KINDS if name not in self._seen]

    def begin(self, board: Chessboard) -> LiveViews:
        """Begin to gather views of the camera that is known now."""
        self.colour_camera, self.unit = camera_from_messages(
            "the camera", self._seen, transform_from_extrinsics(self._seen[EXTRINSICS]), self.health
        )
        self.views = LiveViews(board, self.colour_camera, self.unit)
        return self.views

    def check(self) -> None:
        """Notice a camera that has stopped.

        Raises:
            InputError: When no picture has come for long.
        """
        if time.monotonic() - self._heard > self._patience:
            raise InputError(
                f"no picture on {self._topic(COLOUR)} for {self._patience:.0f} s; is the camera running?"
            )

    def _topic(self, name: str) -> str:
        return f"/{self._camera}/{name}"

    def _keep(self, name: str) -> Any:
        return lambda message: self._seen.setdefault(name, message)

    def _diagnose(self, message: DiagnosticArray) -> None:
        self.health = camera_health(message, self.health)

    def _take_colour(self, image: Image) -> None:
        self._heard = time.monotonic()
        if self.views is not None:
            colour = colour_from_image(image)
            refuse_other_size("colour", colour.shape, self.colour_camera)
            self.views.push_colour(stamp_seconds(image.header.stamp), colour)

    def _take_depth(self, image: Image) -> None:
        if self.views is not None:
            depth = depth_from_image(image)
            refuse_other_size("depth", depth.shape, self.unit.depth_camera)
            self.views.push_depth(stamp_seconds(image.header.stamp), depth)
