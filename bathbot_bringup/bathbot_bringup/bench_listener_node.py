"""Counts corrected frames by their stamps, without decoding them."""

import time

from bathbot_depthcorr.serialized_image import stamp_of
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from sensor_msgs.msg import Image


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
