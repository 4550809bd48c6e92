"""The registered region of `depth_corrector`: its topics and the colour camera it depends on."""

from collections.abc import Callable

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from bathbot_depthcorr.live.live_region import LiveRegion
from bathbot_depthcorr.node.endpoints_node import EndpointOwner, guarded
from bathbot_depthcorr.ros.messages import image_from_depth, info_from_pinhole, pinhole_from_info

COLOUR_INFO = "camera/camera/color/camera_info"


class RegisteredOutput:
    """Publishes depth as the colour camera sees it, for one region of the colour image."""

    def __init__(self, node: EndpointOwner, region: LiveRegion, fail: Callable[[Exception], None]) -> None:
        """Advertise the region and listen to the colour camera.

        Args:
            node: That owns publishers and subscription.
            region: The region; somebody else tells it of the depth camera and the transform.
            fail: Called with what is wrong with a camera_info.
        """
        self._region, self._frame = region, ""
        self._image = node.publisher(Image, "depth/registered/image", 5)
        self._info = node.publisher(CameraInfo, "depth/registered/camera_info", 5)
        node.listen(CameraInfo, COLOUR_INFO, guarded(self._meet_colour, fail), 5)

    def publish(self, corrected: NDArray[np.float32], stamp: Time) -> None:
        """Publish the region of a corrected frame [m], shape (H, W), taken at `stamp`, if it can be made."""
        seen = self._region.apply(corrected)
        if seen is not None:
            header = Header(stamp=stamp, frame_id=self._frame)
            self._image.publish(image_from_depth(seen.depth, header))
            self._info.publish(info_from_pinhole(seen.camera, header))

    def _meet_colour(self, info: CameraInfo) -> None:
        self._frame = info.header.frame_id
        self._region.meet_colour_camera(pinhole_from_info(info))
