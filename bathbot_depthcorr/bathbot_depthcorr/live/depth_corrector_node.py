"""Node `depth_corrector`: raw depth of a D455 in, corrected metres and the corrected transform out."""

import time

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import QoSProfile, ReliabilityPolicy
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image

from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.live.corrected_output_node import CorrectedOutput
from bathbot_depthcorr.live.frame_pace import FramePace
from bathbot_depthcorr.live.live_correction import LiveCorrection
from bathbot_depthcorr.live.registered_output_node import RegisteredOutput
from bathbot_depthcorr.live.settings import Settings
from bathbot_depthcorr.node.endpoints_node import guarded
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, LATCHED, StageNode
from bathbot_depthcorr.ros.camera_health import camera_health
from bathbot_depthcorr.ros.messages import (
    depth_from_image,
    extrinsics_from_transform,
    header_of,
    pinhole_from_info,
    transform_from_extrinsics,
)
from bathbot_depthcorr.ros.serialized_image import read_image
from bathbot_depthcorr.ros.verdict import Verdict

CAMERA = "camera/camera"
WAITING, PATIENCE = 8, 0.25  # frames, and [s], that may wait while the machine is busy elsewhere
BEST_EFFORT = QoSProfile(depth=WAITING, reliability=ReliabilityPolicy.BEST_EFFORT)


class DepthCorrector(StageNode):
    """Corrects depth images in a thread of its own; refuses another camera's calibration."""

    def __init__(self) -> None:
        super().__init__("depth_corrector", Settings)

    def setup(self, settings: Settings) -> None:
        """Load the calibration and compile its loop before the first frame."""
        self._settings = settings
        self._stored = load(settings.calibration) if settings.calibration else None
        if self._stored is not None:
            self._stored.warm_up()
        self._output = CorrectedOutput(self, WAITING, settings.publish_mm)

    def start(self) -> None:
        """Listen to the camera."""
        self._live, self._pace = LiveCorrection(self._settings, self._stored), FramePace(time.monotonic())
        self._info: CameraInfo | None = None
        # The fitted transform, or the factory's while depth passes uncorrected.
        self._transform = extrinsics_from_transform(self._stored.T_colour_depth) if self._stored else None
        self._told: Verdict | None = None
        self._raw = None
        self._registered: RegisteredOutput | None = None
        if any(self._settings.registered_roi):
            self._registered = RegisteredOutput(self, self._live.region, self._fail)
        self._worker = self.worker(self._correct, self._fail, waiting=WAITING, patience=PATIENCE)
        self.listen(CameraInfo, f"{CAMERA}/depth/camera_info", guarded(self._meet_camera, self._fail), 5)
        # raw: the pixels are read in place
        self.listen(Image, f"{CAMERA}/depth/image_rect_raw", self._worker.put, BEST_EFFORT, raw=True)
        factory = f"{CAMERA}/extrinsics/depth_to_color"
        self.listen(Extrinsics, factory, guarded(self._meet_factory, self._fail), LATCHED)
        self.listen(DiagnosticArray, "/diagnostics", self._meet_health, 10)
        self.every(1.0, self._count)
        self._tell()

    def _meet_camera(self, info: CameraInfo) -> None:
        camera, self._info = pinhole_from_info(info), info
        if self._live.meet_camera(camera):
            self._publish_transform()
            self._tell()

    def _meet_factory(self, extrinsics: Extrinsics) -> None:
        if self._stored is not None:  # the calibration has a better one
            return
        self._transform = extrinsics
        self._publish_transform()
        if self._registered is not None:
            self._live.region.meet_transform(transform_from_extrinsics(extrinsics))

    def _meet_health(self, diagnostics: DiagnosticArray) -> None:
        if self._live.meet_health(camera_health(diagnostics, self._live.health)):
            self._publish_transform()

    def _publish_transform(self) -> None:
        if self._live.active is not None and self._transform is not None:
            self._output.publish_transform(self._transform)

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
            if self._pace.see(time.monotonic()):
                self._live.judge(corrected)
        if self._live.verdict() != self._told:
            self._tell()

    def _fail(self, error: Exception) -> None:
        self._told = None
        self.get_logger().error(str(error), throttle_duration_sec=5.0)
        self.report(ERROR, str(error))

    def _count(self) -> None:
        if self._pace.count(time.monotonic(), self._worker.done):
            self._live.lose_sight()
        if self._told is not None:  # otherwise an error is on show until the next good frame
            self._tell()

    def _tell(self) -> None:
        self._told = self._live.verdict()
        values = self._live.values(self._pace.fps, self._worker.dropped)
        self.report(self._told.level.value, self._told.message, **values)


def main() -> None:
    """Run the node."""
    run(DepthCorrector)


if __name__ == "__main__":
    main()
