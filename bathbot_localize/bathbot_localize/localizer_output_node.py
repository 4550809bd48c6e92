"""What `target_localizer` publishes: targets, surface, body cloud and the place of the camera."""

from bathbot_depthcorr.node.endpoints_node import LATCHED, EndpointOwner
from bathbot_depthcorr.ros.messages import depth_from_image, stamp_from_seconds, stamp_seconds
from builtin_interfaces.msg import Time
from sensor_msgs.msg import Image, PointCloud2
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import Detection2DArray

from bathbot_localize.messages import (
    cloud_from_surface,
    contact_targets_from,
    regions_from_detections,
    stamped_from_transform,
)
from bathbot_localize.target.localizer_session import LocalizerSession
from bathbot_msgs.msg import ContactTargets

TARGETS, SURFACE, BODY = "contact_targets", "surface", "body_cloud"


class LocalizerOutput:
    """Turns pictures into what is published of them; one thread may call each method."""

    def __init__(self, node: EndpointOwner, session: LocalizerSession) -> None:
        """Advertise the topics."""
        self._session, self._settings = session, session.settings
        self._targets = node.publisher(ContactTargets, TARGETS, 10)
        self._surface = node.publisher(PointCloud2, SURFACE, 5)
        self._body = node.publisher(PointCloud2, BODY, 1)
        self._static = node.publisher(TFMessage, "/tf_static", LATCHED)

    def locate(self, pair: tuple[Detection2DArray, Image]) -> None:
        """Publish the targets of the regions of one picture."""
        detections, image = pair
        stamp = stamp_seconds(image.header.stamp)
        looked = self._session.locate(depth_from_image(image), stamp, regions_from_detections(detections))
        self._targets.publish(contact_targets_from(looked.targets, self._header(detections.header.stamp)))
        self._session.solve(TARGETS)

    def measure(self, image: Image) -> None:
        """Publish the surface of the chosen region."""
        points = self._session.surface(depth_from_image(image), stamp_seconds(image.header.stamp))
        self._surface.publish(cloud_from_surface(points, self._header(image.header.stamp)))
        self._session.solve(SURFACE)

    def look(self, image: Image) -> None:
        """Publish the cloud of the body, stamped when all of it was last known to be there."""
        known = self._session.body(depth_from_image(image), stamp_seconds(image.header.stamp))
        stamp = stamp_from_seconds(known.stamp) if len(known.points) else image.header.stamp
        self._body.publish(cloud_from_surface(known.points[None], self._header(stamp)))
        self._session.solve(BODY)

    def place(self, stamp: Time) -> bool:
        """Join the camera's tree to the base, once; tell whether that was now."""
        transform = self._session.place()
        if transform is None:
            return False
        entry = stamped_from_transform(transform, self._header(stamp), self._settings.camera_frame)
        self._static.publish(TFMessage(transforms=[entry]))
        return True

    def _header(self, stamp: Time) -> Header:
        return Header(stamp=stamp, frame_id=self._settings.base_frame)
