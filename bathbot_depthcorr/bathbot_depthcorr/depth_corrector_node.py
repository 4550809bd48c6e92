"""Node `depth_corrector`: raw depth of a D455 in, corrected metres and the corrected transform out."""

import time

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import qos_profile_sensor_data
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image

from bathbot_depthcorr.camera_health import camera_health
from bathbot_depthcorr.correction import load
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.live_correction import Level, LiveCorrection
from bathbot_depthcorr.messages import (
    depth_from_image,
    extrinsics_from_transform,
    image_from_depth,
    image_mm_from_depth,
    pinhole_from_info,
)
from bathbot_depthcorr.newest_worker import NewestWorker
from bathbot_depthcorr.settings import Settings
from bathbot_depthcorr.stage_node import ERROR, LATCHED, OK, WARN, StageNode, run

_LEVELS = {Level.OK: OK, Level.WARN: WARN, Level.ERROR: ERROR}
CAMERA = "camera/camera"


class DepthCorrector(StageNode):
    """Corrects depth images in a thread of its own; refuses another camera's calibration."""

    def __init__(self) -> None:
        super().__init__("depth_corrector", Settings)

    def setup(self, settings: Settings) -> None:
        """Load the calibration and compile its loop before the first frame."""
        self._settings = settings
        self._stored = load(settings.calibration) if settings.calibration else None
        if self._stored is not None:
            camera = self._stored.depth_camera
            self._stored.apply(np.full((camera.height, camera.width), np.nan, np.float32))
        self._depth = self.create_lifecycle_publisher(Image, "depth/corrected/image", 5)
        self._depth_info = self.create_lifecycle_publisher(CameraInfo, "depth/corrected/camera_info", 5)
        self._transform = self.create_lifecycle_publisher(
            Extrinsics, "depth/corrected/depth_to_color", LATCHED
        )
        self._depth_mm = (
            self.create_lifecycle_publisher(Image, "depth/corrected/image_mm", 5)
            if settings.publish_mm
            else None
        )

    def start(self) -> None:
        """Listen to the camera."""
        self._live = LiveCorrection(self._settings, self._stored)
        self._info: CameraInfo | None = None
        self._factory: Extrinsics | None = None
        self._last = (time.monotonic(), 0)
        self._fps = 0.0
        self._worker = NewestWorker(self._correct, self._fail)
        self._subscriptions_ours = [
            self.create_subscription(CameraInfo, f"{CAMERA}/depth/camera_info", self._meet_camera, 5),
            self.create_subscription(
                Image, f"{CAMERA}/depth/image_rect_raw", self._worker.put, qos_profile_sensor_data
            ),
            self.create_subscription(
                Extrinsics, f"{CAMERA}/extrinsics/depth_to_color", self._meet_factory, LATCHED
            ),
            self.create_subscription(DiagnosticArray, "/diagnostics", self._meet_health, 10),
        ]
        self._clock_timer = self.create_timer(1.0, self._count)
        self._tell()

    def stop(self) -> None:
        """Stop listening."""
        self._worker.close()
        self.destroy_timer(self._clock_timer)
        for subscription in self._subscriptions_ours:
            self.destroy_subscription(subscription)

    def teardown(self) -> None:
        """Let go of the publishers."""
        for publisher in (self._depth, self._depth_info, self._transform, self._depth_mm):
            if publisher is not None:
                self.destroy_publisher(publisher)

    def _meet_camera(self, info: CameraInfo) -> None:
        try:
            changed = self._live.meet_camera(pinhole_from_info(info))
        except BathbotError as error:
            self._fail(error)
            return
        self._info = info
        if changed:
            self._publish_transform()
        self._tell()

    def _meet_factory(self, extrinsics: Extrinsics) -> None:
        self._factory = extrinsics
        self._publish_transform()

    def _meet_health(self, diagnostics: DiagnosticArray) -> None:
        if self._live.meet_health(camera_health(diagnostics, self._live.health)):
            self._publish_transform()

    def _publish_transform(self) -> None:
        """Publish the fitted transform, or the factory's while depth passes uncorrected."""
        if self._live.active is None:
            return
        if self._stored is not None:
            self._transform.publish(extrinsics_from_transform(self._stored.T_colour_depth))
        elif self._factory is not None:
            self._transform.publish(self._factory)

    def _correct(self, image: Image) -> None:
        """Correct one frame; runs in the worker's thread."""
        corrected = self._live.process(depth_from_image(image))
        if corrected is not None:
            self._depth.publish(image_from_depth(corrected, image.header))
            if self._depth_mm is not None:
                self._depth_mm.publish(image_mm_from_depth(corrected, image.header))
            self._info.header = image.header
            self._depth_info.publish(self._info)
        self._tell()

    def _fail(self, error: Exception) -> None:
        self.get_logger().error(str(error), throttle_duration_sec=5.0)
        self.report(ERROR, str(error))

    def _count(self) -> None:
        now, done = time.monotonic(), self._worker.done
        self._fps = (done - self._last[1]) / (now - self._last[0])
        self._last = (now, done)

    def _tell(self) -> None:
        verdict, health = self._live.verdict(), self._live.health
        self.report(
            _LEVELS[verdict.level], verdict.message,
            model=self._stored.model if self._stored else "none", serial=health.serial or "unknown",
            fill=f"{self._live.fill:.3f}", sigma_mm=f"{1e3 * self._live.sigma:.2f}", fps=f"{self._fps:.1f}",
            dropped=self._worker.dropped, temperature=f"{health.temperature:.1f}",
        )  # fmt: skip


def main() -> None:
    """Run the node."""
    run(DepthCorrector)


if __name__ == "__main__":
    main()
