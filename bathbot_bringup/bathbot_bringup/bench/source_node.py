"""A depth camera for the bench: a few frames, made before, sent in turn at an exact rate.

Runs as a process of its own: `python -m bathbot_bringup.bench.source_node WIDTH HEIGHT RATE`.
"""

import signal
import sys
import threading
import time

import rclpy
from bathbot_depthcorr.node.dds.participant_node import begin, joining
from bathbot_depthcorr.node.stage_node import LATCHED, OK
from bathbot_depthcorr.ros.messages import (
    extrinsics_from_transform,
    image_mm_from_depth,
    info_from_pinhole,
    stamp_from_seconds,
)
from bathbot_depthcorr.ros.serialized_image import stamp_of
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from bathbot_bringup.bench.scene import SERIAL, TEMPERATURE, bench_camera, bench_correction, bench_frames


class BenchListener:
    """Remembers when each corrected frame arrived, and what the corrector last said of itself.

    Attributes:
        arrivals: Time of arrival [s] by stamp [s].
        trouble: The corrector's last message unless all is well.
        counted: Frames the corrector itself says it had to drop.
    """

    def __init__(self, node: Node) -> None:
        """Subscribe with a node that somebody spins."""
        self.arrivals: dict[float, float] = {}
        self.trouble, self.counted = "it has not reported yet", 0
        node.create_subscription(Image, "depth/corrected/image", self._hear_frame, 30, raw=True)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._hear_status, 10)

    def _hear_frame(self, message: bytes) -> None:
        self.arrivals[stamp_of(message)] = time.time()

    def _hear_status(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == "depth_corrector":
                self.trouble = "" if status.level == DiagnosticStatus.OK else status.message
                values = {entry.key: entry.value for entry in status.values}
                self.counted = int(values.get("dropped", self.counted))


_FRAMES = 4
_PREFIX = "camera/camera"


class BenchSource:
    """Publishes what a D455 publishes of depth, on the topics of its driver."""

    def __init__(self, width: int, height: int) -> None:
        """Make the frames and advertise the topics."""
        with joining():
            self.node = Node("bench_source")
        camera, header = bench_camera(width, height), Header(frame_id="camera_depth_optical_frame")
        self._frames = [image_mm_from_depth(depth, header) for depth in bench_frames(camera, _FRAMES)]
        self._info_message = info_from_pinhole(camera, header)
        self._depth = self.node.create_publisher(Image, f"{_PREFIX}/depth/image_rect_raw", 5)
        self._info = self.node.create_publisher(CameraInfo, f"{_PREFIX}/depth/camera_info", 5)
        self._factory = self.node.create_publisher(
            Extrinsics, f"{_PREFIX}/extrinsics/depth_to_color", LATCHED
        )
        self._factory.publish(extrinsics_from_transform(bench_correction(camera).T_colour_depth))
        self._diagnostics = self.node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    def send(self, number: int, stamp: float) -> None:
        """Send frame `number` with the time `stamp` [s]."""
        image = self._frames[number % len(self._frames)]
        image.header.stamp = self._info_message.header.stamp = stamp_from_seconds(stamp)
        self._depth.publish(image)
        self._info.publish(self._info_message)

    def tell_health(self) -> None:
        """Tell serial number and temperature, as the driver does every second."""
        reading = KeyValue(key="Asic Temperature", value=str(TEMPERATURE))
        status = DiagnosticStatus(
            level=OK, name="bench_source: Temperatures", hardware_id=SERIAL, values=[reading]
        )
        self._diagnostics.publish(DiagnosticArray(status=[status]))


def stream(source: BenchSource, rate: float, stopping: threading.Event) -> None:
    """Send frames at `rate` [Hz] until told to stop; one that is late goes at once, none is left out."""
    epoch, number = time.time(), 0
    while not stopping.is_set():
        due = epoch + number / rate
        time.sleep(max(due - time.time(), 0.0))
        if number % max(round(rate), 1) == 0:
            source.tell_health()
        source.send(number, due)
        number += 1


def main() -> None:
    """Stream until SIGINT or SIGTERM."""
    width, height, rate = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    begin(signal_handler_options=SignalHandlerOptions.NO)
    source = BenchSource(width, height)
    try:
        stream(source, rate, stopping)
    finally:
        source.node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
