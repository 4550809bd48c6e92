"""What `target_localizer` hears of cameras, frames and classes, handed to the session as it comes."""

from collections.abc import Callable
from functools import partial
from typing import Any

from bathbot_depthcorr.node.endpoints_node import LATCHED, EndpointOwner, guarded
from bathbot_depthcorr.ros.messages import pinhole_from_info, transform_from_extrinsics
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import LabelInfo

from bathbot_localize.messages import transforms_from_tf
from bathbot_localize.target.localizer_session import LocalizerSession

# Several publishers are latched on /tf_static: room for one message of each.
_ALL_LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class LocalizerInput:
    """Decodes; what cannot be decoded is a problem until the next message can."""

    def __init__(
        self,
        node: EndpointOwner,
        session: LocalizerSession,
        fail: Callable[[str, Exception], None],
        static_came: Callable[[], None],
    ) -> None:
        """Listen.

        Args:
            node: That owns the subscriptions.
            session: That is told.
            fail: Called with the name of an input and what is wrong with it.
            static_came: Called after static transforms have come.
        """
        self._session, self._fail, self._static_came = session, fail, static_came
        node.listen(TFMessage, "/tf_static", self._take_static, _ALL_LATCHED)
        node.listen(TFMessage, "/tf", self._take_moving, 100)
        take = self._taker("extrinsics", transform_from_extrinsics, session.meet_extrinsics)
        node.listen(Extrinsics, "depth/corrected/depth_to_color", take, LATCHED)
        take = self._taker("colour camera_info", pinhole_from_info, session.meet_colour_camera)
        node.listen(CameraInfo, "camera/camera/color/camera_info", take, qos_profile_sensor_data)
        take = self._taker("depth camera_info", pinhole_from_info, session.meet_depth_camera)
        node.listen(CameraInfo, "depth/corrected/camera_info", take, qos_profile_sensor_data)
        node.listen(LabelInfo, "skin_regions/label_info", self._take_labels, LATCHED)

    def _taker(
        self, name: str, decode: Callable[[Any], Any], meet: Callable[[Any], None]
    ) -> Callable[[Any], None]:
        def take(message: Any) -> None:
            meet(decode(message))
            self._session.solve(name)

        return guarded(take, partial(self._fail, name))

    def _take_moving(self, message: TFMessage) -> None:
        for entry in transforms_from_tf(message):
            self._session.add_transform(entry.parent, entry.child, entry.transform, entry.stamp)

    def _take_static(self, message: TFMessage) -> None:
        for entry in transforms_from_tf(message):
            self._session.add_transform(entry.parent, entry.child, entry.transform, None)
        self._static_came()

    def _take_labels(self, message: LabelInfo) -> None:
        self._session.names = tuple(entry.class_name for entry in message.class_map)
