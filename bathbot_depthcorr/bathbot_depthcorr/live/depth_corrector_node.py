"""Node `depth_corrector`: raw depth of a D455 in, corrected metres and the corrected transform out."""

import time

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from numpy.typing import NDArray
from rclpy.qos import QoSProfile, ReliabilityPolicy
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image

from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.geometry.registration import Region
from bathbot_depthcorr.live.corrected_output_node import CorrectedOutput
from bathbot_depthcorr.live.frame_quality import quality_values
from bathbot_depthcorr.live.live_correction import Level, LiveCorrection, Verdict
from bathbot_depthcorr.live.registered_output_node import RegisteredOutput
from bathbot_depthcorr.live.settings import Settings
from bathbot_depthcorr.node.newest_worker import NewestWorker
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, LATCHED, OK, WARN, StageNode
from bathbot_depthcorr.ros.camera_health import camera_health
from bathbot_depthcorr.ros.messages import (
    depth_from_image,
    extrinsics_from_transform,
    header_of,
    pinhole_from_info,
    transform_from_extrinsics,
)
from bathbot_depthcorr.ros.serialized_image import read_image

_LEVELS = {Level.OK: OK, Level.WARN: WARN, Level.ERROR: ERROR}
CAMERA = "camera/camera"
WAITING, PATIENCE = 8, 0.25  # frames, and [s], that may wait while the machine is busy elsewhere
BEST_EFFORT = QoSProfile(depth=WAITING, reliability=ReliabilityPolicy.BEST_EFFORT)
JUDGE_EVERY, SILENCE = 1.0, 3.0  # [s] between two close looks, without frames


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
        self._output = CorrectedOutput(self, WAITING, settings.publish_mm)

    def start(self) -> None:
        """Listen to the camera."""
        self._live = LiveCorrection(self._settings, self._stored)
        self._info: CameraInfo | None = None
        self._factory: Extrinsics | None = None
        self._told: Verdict | None = None
        self._raw: NDArray[np.float32] | None = None
        self._judged, self._seen, self._fps = 0.0, 0.0, 0.0
        self._last = (time.monotonic(), 0)
        self._registered = self._open_region()
        self._worker = NewestWorker(self._correct, self._fail, WAITING, PATIENCE)
        self._subscriptions_ours = [
            self.create_subscription(CameraInfo, f"{CAMERA}/depth/camera_info", self._meet_camera, 5),
            self.create_subscription(  # raw: the pixels are read in place
                Image, f"{CAMERA}/depth/image_rect_raw", self._worker.put, BEST_EFFORT, raw=True
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
        if self._registered is not None:
            self._registered.close()

    def teardown(self) -> None:
        """Let go of the publishers."""
        self._output.close()

    def _open_region(self) -> RegisteredOutput | None:
        """Offer the registered region, if one is wanted."""
        region = Region(*self._settings.registered_roi)
        if not region.width:
            return None
        topic, farthest = f"{CAMERA}/color/camera_info", self._settings.max_depth
        output = RegisteredOutput(self, topic, region, farthest, self._fail)
        if self._stored is not None:
            output.view.meet_transform(self._stored.T_colour_depth)
        return output

    def _meet_camera(self, info: CameraInfo) -> None:
        try:
            camera = pinhole_from_info(info)
        except BathbotError as error:
            self._fail(error)
            return
        self._info = info
        if self._registered is not None:
            self._registered.view.meet_depth_camera(camera)
        if self._live.meet_camera(camera):
            self._publish_transform()
            self._tell()

    def _meet_factory(self, extrinsics: Extrinsics) -> None:
        if self._stored is not None:  # the calibration has a better one
            return
        self._factory = extrinsics
        self._publish_transform()
        if self._registered is not None:
            try:
                self._registered.view.meet_transform(transform_from_extrinsics(extrinsics))
            except BathbotError as error:
                self._fail(error)

    def _meet_health(self, diagnostics: DiagnosticArray) -> None:
        if self._live.meet_health(camera_health(diagnostics, self._live.health)):
            self._publish_transform()

    def _publish_transform(self) -> None:
        """Publish the fitted transform, or the factory's while depth passes uncorrected."""
        if self._live.active is None:
            return
        if self._stored is not None:
            self._output.publish_transform(extrinsics_from_transform(self._stored.T_colour_depth))
        elif self._factory is not None:
            self._output.publish_transform(self._factory)

    def _correct(self, message: bytes) -> None:
        """Correct one frame, in memory that the frame before used; runs in the worker's thread."""
        image = read_image(message)
        self._raw = depth_from_image(image, self._raw)
        corrected = self._live.process(self._raw, self._output.pixels(self._raw.shape))
        if corrected is not None:
            header = header_of(image)
            self._output.publish(header, self._info)
            if self._registered is not None:
                self._registered.publish(corrected, header.stamp)
            self._seen = time.monotonic()
            if self._seen - self._judged > JUDGE_EVERY:
                self._judged = self._seen
                self._live.judge(corrected)
        if self._verdict() != self._told:
            self._tell()

    def _fail(self, error: Exception) -> None:
        self._told = None
        self.get_logger().error(str(error), throttle_duration_sec=5.0)
        self.report(ERROR, str(error))

    def _count(self) -> None:
        now, done = time.monotonic(), self._worker.done
        self._fps = (done - self._last[1]) / (now - self._last[0])
        self._last = (now, done)
        if now - self._seen > SILENCE:
            self._live.lose_sight()
        if self._told is not None:  # otherwise an error is on show until the next good frame
            self._tell()

    def _verdict(self) -> Verdict:
        verdict = self._live.verdict()
        if (
            verdict.level is not Level.ERROR
            and self._registered is not None
            and self._registered.view.trouble
        ):
            return Verdict(Level.ERROR, f"registered_roi: {self._registered.view.trouble}")
        return verdict

    def _tell(self) -> None:
        self._told, health = self._verdict(), self._live.health
        self.report(
            _LEVELS[self._told.level], self._told.message,
            model=self._stored.model if self._stored else "none", serial=health.serial or "unknown",
            fps=f"{self._fps:.1f}", dropped=self._worker.dropped, temperature=f"{health.temperature:.1f}",
            **quality_values(self._live.quality, self._settings.wall_distance),
        )  # fmt: skip


def main() -> None:
    """Run the node."""
    run(DepthCorrector)


if __name__ == "__main__":
    main()
