"""Finds skin regions: `camera/camera/color/image_raw` -> `skin_regions`, same header."""

import time
from typing import Any

from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, LATCHED, OK, WARN, StageNode
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import Image
from std_msgs.msg import Header
from vision_msgs.msg import Detection2DArray, LabelInfo

from bathbot_perception.detection.detector import load
from bathbot_perception.detection.settings import SkinDetectorSettings
from bathbot_perception.detection.smoothing import Smoothing
from bathbot_perception.detection.throughput import Throughput
from bathbot_perception.errors import PerceptionError
from bathbot_perception.messages import ImageDetection, label_info

COLOUR_TOPIC = "camera/camera/color/image_raw"


class SkinDetector(StageNode):
    """Runs the network on the newest picture, in a thread of its own; old pictures are dropped."""

    def __init__(self, **options: Any) -> None:
        """Declare the parameters; `options` are those of rclpy's `Node`."""
        super().__init__("skin_detector", SkinDetectorSettings, **options)

    def setup(self, settings: SkinDetectorSettings) -> None:
        """Load the model."""
        self._detector = load(settings=settings)
        self._settings = settings
        self._regions = self.publisher(Detection2DArray, "skin_regions", 5)
        self._labels = self.publisher(LabelInfo, "skin_regions/label_info", LATCHED)
        stamp = self.get_clock().now().to_msg()
        self._labels.publish(label_info(Header(stamp=stamp), settings.score_threshold))
        self.get_logger().info(f"network of {self._detector.size} px runs on {self._detector.provider}")

    def start(self) -> None:
        """Listen to the camera."""
        self._throughput = Throughput(time.monotonic())
        self._detection = ImageDetection(self._detector, Smoothing(self._settings.smoothing))
        self._worker = self.worker(self._detect, self._fail)
        self.listen(Image, COLOUR_TOPIC, self._worker.put, qos_profile_sensor_data)
        self.every(1.0, self._diagnose)

    def _detect(self, image: Image) -> None:
        begun = time.monotonic()
        found = self._detection.detect(image)
        self._regions.publish(found)
        ended = time.monotonic()
        latency = (self.get_clock().now() - Time.from_msg(image.header.stamp)).nanoseconds * 1e-9
        self._throughput.add(ended, ended - begun, latency, len(found.detections))

    def _fail(self, error: Exception) -> None:
        if not isinstance(error, PerceptionError):
            self.get_logger().fatal(f"{type(error).__name__}: {error}")
        self._throughput.fail(f"{error}")

    def _diagnose(self) -> None:
        recent = self._throughput.recent(time.monotonic())
        values = {"provider": self._detector.provider, "dropped": self._worker.dropped, **recent.values}
        if recent.error:
            self.get_logger().error(recent.error, throttle_duration_sec=10.0)
            self.report(ERROR, recent.error, **values)
        elif recent.pictures == 0:
            self.report(
                WARN,
                f"no picture on {self.resolve_topic_name(COLOUR_TOPIC)}; is the camera running?",
                **values,
            )
        elif recent.regions == 0:
            self.report(WARN, "no detection: no bare skin in view, or the view is dark or foggy", **values)
        else:
            self.report(OK, "detecting", **values)


def main() -> None:
    """Run the node."""
    run(SkinDetector)


if __name__ == "__main__":
    main()
