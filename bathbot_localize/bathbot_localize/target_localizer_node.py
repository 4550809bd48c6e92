"""Locates skin: `skin_regions` + `depth/corrected/image` -> `contact_targets`, `surface`, `body_cloud`.

Also publishes the pose of the camera in the base frame on /tf_static, from the hand-eye result.
"""

from functools import partial
from typing import Any

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import StageNode
from bathbot_depthcorr.ros.messages import stamp_seconds
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image
from vision_msgs.msg import Detection2DArray

from bathbot_localize.arm.arm_shape import installed_shape
from bathbot_localize.hand_eye.calibration_file import load_hand_eye
from bathbot_localize.localizer_input_node import LocalizerInput
from bathbot_localize.localizer_output_node import BODY, SURFACE, TARGETS, LocalizerOutput
from bathbot_localize.target.localizer import warm_up
from bathbot_localize.target.localizer_session import LocalizerSession, UnknownRegionError
from bathbot_localize.target.meeting import Meeting, NoPictureError
from bathbot_localize.target.schedule import Schedule
from bathbot_localize.target_localizer_settings import TargetLocalizerSettings
from bathbot_msgs.srv import SelectRegion


class TargetLocalizer(StageNode):
    """Keeps a short history of depth pictures and meets each list of regions with the one of its time."""

    def __init__(self, **options: Any) -> None:
        """Declare the parameters; `options` are those of rclpy's `Node`."""
        super().__init__("target_localizer", TargetLocalizerSettings, **options)

    def setup(self, settings: TargetLocalizerSettings) -> None:
        """Load the hand-eye result."""
        T_base_colour = load_hand_eye(settings.hand_eye).T_base_camera
        self._session = LocalizerSession(settings, T_base_colour, installed_shape())
        warm_up()
        self._output = LocalizerOutput(self, self._session)

    def start(self) -> None:
        """Listen to cameras, detector and arm."""
        session, settings = self._session, self._session.settings
        session.problems.clear()
        self._meeting: Meeting[Detection2DArray, Image] = Meeting(
            settings.depth_history, settings.max_stamp_difference
        )
        self._schedule = Schedule(**{SURFACE: settings.surface_rate, BODY: settings.cloud_rate})
        self._locating = self.worker(self._output.locate, partial(self._fail, TARGETS))
        self._measuring = self.worker(self._output.measure, partial(self._fail, SURFACE))
        self._looking = self.worker(self._output.look, partial(self._fail, BODY))
        LocalizerInput(self, session, self._fail, self._place)
        self.listen(Detection2DArray, "skin_regions", self._take_regions, 10)
        self.listen(Image, "depth/corrected/image", self._take_depth, qos_profile_sensor_data)
        self.serve(SelectRegion, "select_region", self._select)
        self.every(0.5, self._diagnose)

    def _place(self) -> None:
        if self._output.place(self.get_clock().now().to_msg()):
            settings = self._session.settings
            self.get_logger().info(f"{settings.camera_frame} is placed in {settings.base_frame}")

    def _take_regions(self, message: Detection2DArray) -> None:
        self._session.seen(self.now(), regions=True)
        self._meeting.add_regions(stamp_seconds(message.header.stamp), message)
        self._meet()

    def _take_depth(self, message: Image) -> None:
        stamp = stamp_seconds(message.header.stamp)
        self._session.seen(self.now(), depth=True)
        self._meeting.add_depth(stamp, message)
        self._meet()
        if self._session.roi is not None and self._schedule.due(SURFACE, stamp):
            self._measuring.put(message)
        if self._session.sees_body and self._schedule.due(BODY, stamp):
            self._looking.put(message)

    def _meet(self) -> None:
        """Hand over the newest regions as soon as the depth picture of their time is there."""
        if self._session.missing():
            return
        try:
            for pair in self._meeting.take():
                self._locating.put(pair)
        except NoPictureError as error:
            self._fail(TARGETS, error)

    def _select(self, request: SelectRegion.Request, answer: SelectRegion.Response) -> SelectRegion.Response:
        try:
            self._session.select(request.region)
        except UnknownRegionError as error:
            answer.error_code, answer.error_msg = SelectRegion.Response.UNKNOWN_REGION, str(error)
        return answer

    def _diagnose(self) -> None:
        verdict, dropped = self._session.verdict(self.now()), self._locating.dropped + self._measuring.dropped
        self.report(verdict.level.value, verdict.message, region=self._session.region, dropped=dropped)

    def _fail(self, name: str, error: Exception) -> None:
        self._schedule.repeat(name)
        self._session.fail(name, error)
        if not isinstance(error, BathbotError):
            self.get_logger().error(f"{name}: {self._session.problems[name]}", throttle_duration_sec=10.0)


def main() -> None:
    """Run the node."""
    run(TargetLocalizer)


if __name__ == "__main__":
    main()
