"""Locates skin: `skin_regions` + `depth/corrected/image` -> `contact_targets`, `surface`, `body_cloud`.

Also publishes the pose of the camera in the base frame on /tf_static, from the hand-eye result.
"""

from collections.abc import Callable
from typing import Any

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.geometry.frame_tree import UnknownFrameError
from bathbot_depthcorr.node.newest_worker import NewestWorker
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, LATCHED, OK, WARN, StageNode
from bathbot_depthcorr.ros.messages import (
    depth_from_image,
    pinhole_from_info,
    stamp_seconds,
    transform_from_extrinsics,
)
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import Detection2DArray, LabelInfo

from bathbot_localize.arm.arm_shape import installed_shape
from bathbot_localize.hand_eye.calibration_file import load_hand_eye
from bathbot_localize.messages import (
    cloud_from_surface,
    contact_targets_from,
    regions_from_detections,
    stamped_from_transform,
    transforms_from_tf,
)
from bathbot_localize.target.localizer import warm_up
from bathbot_localize.target.localizer_session import LocalizerSession, UnknownRegionError
from bathbot_localize.target.stamp_buffer import StampBuffer
from bathbot_localize.target_localizer_settings import TargetLocalizerSettings
from bathbot_msgs.msg import ContactTargets
from bathbot_msgs.srv import SelectRegion

# Several publishers are latched on /tf_static: room for one message of each.
_ALL_LATCHED = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class TargetLocalizer(StageNode):
    """Keeps a short history of depth pictures and meets each list of regions with the one of its time."""

    def __init__(self, **options: Any) -> None:
        """Declare the parameters; `options` are those of rclpy's `Node`."""
        super().__init__("target_localizer", TargetLocalizerSettings, **options)

    def setup(self, settings: TargetLocalizerSettings) -> None:
        """Load the hand-eye result."""
        self._settings = settings
        T_base_colour = load_hand_eye(settings.hand_eye).T_base_camera
        self._session = LocalizerSession(settings, T_base_colour, installed_shape())
        warm_up()
        self._targets = self.create_publisher(ContactTargets, "contact_targets", 10)
        self._surface = self.create_publisher(PointCloud2, "surface", 5)
        self._body = self.create_publisher(PointCloud2, "body_cloud", 1)
        self._static = self.create_publisher(TFMessage, "/tf_static", LATCHED)
        self._static_sent = False

    def start(self) -> None:
        """Listen to cameras, detector and arm."""
        self._depths: StampBuffer[Image] = StampBuffer(self._settings.depth_history)
        self._waiting: Detection2DArray | None = None
        self._next: dict[str, float] = {}
        self._problems: dict[str, str] = {}
        self._locating = NewestWorker(self._locate, lambda error: self._fail("contact_targets", error))
        self._measuring = NewestWorker(self._measure, lambda error: self._fail("surface", error))
        self._looking = NewestWorker(self._look, lambda error: self._fail("body_cloud", error))
        listen, sensor = self.create_subscription, qos_profile_sensor_data
        self._inputs = [
            listen(
                TFMessage, "/tf_static", lambda message: self._take_transforms(message, True), _ALL_LATCHED
            ),
            listen(TFMessage, "/tf", lambda message: self._take_transforms(message, False), 100),
            listen(Extrinsics, "depth/corrected/depth_to_color", self._take_extrinsics, LATCHED),
            listen(CameraInfo, "camera/camera/color/camera_info", self._take_colour_info, sensor),
            listen(CameraInfo, "depth/corrected/camera_info", self._take_depth_info, sensor),
            listen(LabelInfo, "skin_regions/label_info", self._take_labels, LATCHED),
            listen(Detection2DArray, "skin_regions", self._take_regions, 10),
            listen(Image, "depth/corrected/image", self._take_depth, sensor),
        ]
        self._service = self.create_service(SelectRegion, "select_region", self._select)
        self._timer = self.create_timer(0.5, self._diagnose)

    def stop(self) -> None:
        """Listen no more and end the threads."""
        self.destroy_timer(self._timer)
        self.destroy_service(self._service)
        for subscription in self._inputs:
            self.destroy_subscription(subscription)
        self._locating.close()
        self._measuring.close()
        self._looking.close()

    def teardown(self) -> None:
        """Let the publishers go."""
        for publisher in (self._targets, self._surface, self._body, self._static):
            self.destroy_publisher(publisher)

    def _take_transforms(self, message: TFMessage, static: bool) -> None:
        for entry in transforms_from_tf(message):
            self._session.add_transform(
                entry.parent, entry.child, entry.transform, None if static else entry.stamp
            )
        if static and not self._static_sent:
            self._publish_camera()

    def _publish_camera(self) -> None:
        """Join the camera's tree to the base, once its own static transforms have come."""
        try:
            transform = self._session.T_base_camera_link()
        except UnknownFrameError:
            return  # _diagnose tells
        header = Header(stamp=self.get_clock().now().to_msg(), frame_id=self._settings.base_frame)
        entry = stamped_from_transform(transform, header, self._settings.camera_frame)
        self._static.publish(TFMessage(transforms=[entry]))
        self._static_sent = True
        self.get_logger().info(f"{self._settings.camera_frame} is placed in {self._settings.base_frame}")

    def _take_extrinsics(self, message: Extrinsics) -> None:
        self._guarded(
            "extrinsics", lambda: setattr(self._session, "T_colour_depth", transform_from_extrinsics(message))
        )

    def _take_colour_info(self, message: CameraInfo) -> None:
        self._guarded(
            "colour camera_info", lambda: setattr(self._session, "colour_camera", pinhole_from_info(message))
        )

    def _take_depth_info(self, message: CameraInfo) -> None:
        self._guarded(
            "depth camera_info", lambda: setattr(self._session, "depth_camera", pinhole_from_info(message))
        )

    def _take_labels(self, message: LabelInfo) -> None:
        self._session.names = tuple(entry.class_name for entry in message.class_map)

    def _take_regions(self, message: Detection2DArray) -> None:
        self._session.seen(self._now(), regions=True)
        self._waiting = message
        self._meet()

    def _take_depth(self, message: Image) -> None:
        stamp = stamp_seconds(message.header.stamp)
        self._session.seen(self._now(), depth=True)
        self._depths.add(stamp, message)
        self._meet()
        if self._session.roi is not None and self._due("surface", stamp, self._settings.surface_rate):
            self._measuring.put(message)
        if self._session.sees_body and self._due("body_cloud", stamp, self._settings.cloud_rate):
            self._looking.put(message)

    def _due(self, name: str, stamp: float, rate: float) -> bool:
        """Whether it is time for the next of something that is published at a rate [Hz]."""
        period = 1.0 / rate
        due = not 0.0 < self._next.get(name, 0.0) - stamp <= period
        if due:
            self._next[name] = stamp + 0.95 * period  # a picture a little early counts as in time
        return due

    def _meet(self) -> None:
        """Hand over the newest regions as soon as the depth picture of their time is there."""
        if self._waiting is None or self._session.missing():
            return
        stamp, tolerance = stamp_seconds(self._waiting.header.stamp), self._settings.max_stamp_difference
        for _, depth in self._depths.near(stamp, tolerance):
            self._locating.put((self._waiting, depth))
            self._waiting = None
            return
        if self._depths.newest_stamp > stamp + tolerance:
            self._waiting = None
            self._problems["contact_targets"] = (
                f"no depth picture within {tolerance} s of the regions' picture; is depth_history too short?"
            )

    def _locate(self, pair: tuple[Detection2DArray, Image]) -> None:
        detections, image = pair
        stamp = stamp_seconds(image.header.stamp)
        looked = self._session.locate(depth_from_image(image), stamp, regions_from_detections(detections))
        header = Header(stamp=detections.header.stamp, frame_id=self._settings.base_frame)
        self._targets.publish(contact_targets_from(looked.targets, header))
        self._problems.pop("contact_targets", None)

    def _measure(self, image: Image) -> None:
        points = self._session.surface(depth_from_image(image), stamp_seconds(image.header.stamp))
        header = Header(stamp=image.header.stamp, frame_id=self._settings.base_frame)
        self._surface.publish(cloud_from_surface(points, header))
        self._problems.pop("surface", None)

    def _look(self, image: Image) -> None:
        points = self._session.body(depth_from_image(image), stamp_seconds(image.header.stamp))
        header = Header(stamp=image.header.stamp, frame_id=self._settings.base_frame)
        self._body.publish(cloud_from_surface(points[None], header))
        self._problems.pop("body_cloud", None)

    def _select(
        self, request: SelectRegion.Request, response: SelectRegion.Response
    ) -> SelectRegion.Response:
        try:
            self._session.select(request.region)
        except UnknownRegionError as error:
            response.error_code, response.error_msg = SelectRegion.Response.UNKNOWN_REGION, str(error)
        return response

    def _diagnose(self) -> None:
        status = self._session.status(self._now())
        values = {"region": self._session.region, "dropped": self._locating.dropped + self._measuring.dropped}
        if not status.good:
            self.report(WARN, status.message, **values)
        elif problems := dict(self._problems):
            self.report(
                ERROR, "; ".join(f"{name}: {problem}" for name, problem in problems.items()), **values
            )
        elif not self._static_sent:
            self.report(
                WARN, "no static transforms of the camera; does its driver publish /tf_static?", **values
            )
        else:
            self.report(OK, status.message, **values)

    def _guarded(self, name: str, action: Callable[[], None]) -> None:
        try:
            action()
        except BathbotError as error:
            self._fail(name, error)
        else:
            self._problems.pop(name, None)

    def _fail(self, name: str, error: Exception) -> None:
        self._next.pop(name, None)  # the next picture may do
        if isinstance(error, BathbotError):
            self._problems[name] = str(error)
        else:
            self._problems[name] = f"{type(error).__name__}: {error}"
            self.get_logger().error(f"{name}: {self._problems[name]}", throttle_duration_sec=10.0)

    def _now(self) -> float:
        return self.get_clock().now().nanoseconds * 1e-9


def main() -> None:
    """Run the node."""
    run(TargetLocalizer)


if __name__ == "__main__":
    main()
