"""The registered region of `depth_corrector`: its topics and the colour camera it depends on."""

from collections.abc import Callable

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from rclpy.lifecycle import LifecycleNode
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.geometry.registration import Region
from bathbot_depthcorr.live.live_region import LiveRegion
from bathbot_depthcorr.ros.messages import image_from_depth, info_from_pinhole, pinhole_from_info


class RegisteredOutput:
    """Publishes depth as the colour camera sees it, for one region of the colour image.

    Attributes:
        view: The region; it is told of the depth camera and the transform by the node.
    """

    def __init__(
        self,
        node: LifecycleNode,
        topic: str,
        region: Region,
        farthest: float,
        fail: Callable[[Exception], None],
    ) -> None:
        """Advertise the region and listen to the colour camera.

        Args:
            node: That owns publishers and subscription.
            topic: Of the colour camera's camera_info.
            region: Of the colour image.
            farthest: Depth that is carried over at most [m].
            fail: Called with what is wrong with a camera_info.
        """
        self._node, self._fail = node, fail
        self.view = LiveRegion(region, farthest)
        self._frame = ""
        self._image = node.create_lifecycle_publisher(Image, "depth/registered/image", 5)
        self._info = node.create_lifecycle_publisher(CameraInfo, "depth/registered/camera_info", 5)
        self._colour = node.create_subscription(CameraInfo, topic, self._meet_colour, 5)

    def publish(self, corrected: NDArray[np.float32], stamp: Time) -> None:
        """Publish the region of a corrected frame [m], shape (H, W), taken at `stamp`, if it can be made."""
        seen = self.view.apply(corrected)
        if seen is not None:
            header = Header(stamp=stamp, frame_id=self._frame)
            self._image.publish(image_from_depth(seen.depth, header))
            self._info.publish(info_from_pinhole(seen.camera, header))

    def close(self) -> None:
        """Let go of the topics."""
        self._node.destroy_subscription(self._colour)
        self._node.destroy_publisher(self._image)
        self._node.destroy_publisher(self._info)

    def _meet_colour(self, info: CameraInfo) -> None:
        self._frame = info.header.frame_id
        try:
            self.view.meet_colour_camera(pinhole_from_info(info))
        except BathbotError as error:
            self._fail(error)
