"""What `depth_corrector` publishes: corrected depth, its camera_info, and the fitted transform."""

import numpy as np
from numpy.typing import NDArray
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from bathbot_depthcorr.node.endpoints_node import LATCHED, EndpointOwner
from bathbot_depthcorr.ros.messages import DepthImage, image_mm_from_depth


class CorrectedOutput:
    """Publishers of the corrected depth, and the memory of the image they send."""

    def __init__(self, node: EndpointOwner, waiting: int, in_mm: bool) -> None:
        """Advertise the topics.

        Args:
            node: That owns the publishers.
            waiting: Frames that may wait for a slow reader.
            in_mm: Whether to publish 16UC1 millimetres as well.
        """
        self._depth = node.publisher(Image, "depth/corrected/image", waiting)
        self._info = node.publisher(CameraInfo, "depth/corrected/camera_info", waiting)
        self._transform = node.publisher(Extrinsics, "depth/corrected/depth_to_color", LATCHED)
        self._mm = node.publisher(Image, "depth/corrected/image_mm", 5) if in_mm else None
        self._image: DepthImage | None = None

    def pixels(self, shape: tuple[int, int]) -> NDArray[np.float32]:
        """The pixels of the next image [m], shape (H, W): write there, then `publish`."""
        if self._image is None or self._image.depth.shape != shape:
            self._image = DepthImage(*shape)
        return self._image.depth

    def publish(self, header: Header, info: CameraInfo) -> None:
        """Send what `pixels` holds, with the camera_info of the raw depth."""
        self._image.message.header = info.header = header
        self._depth.publish(self._image.message)
        self._info.publish(info)
        if self._mm is not None:
            self._mm.publish(image_mm_from_depth(self._image.depth, header))

    def publish_transform(self, transform: Extrinsics) -> None:
        """Send depth -> colour, latched."""
        self._transform.publish(transform)
