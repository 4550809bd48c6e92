"""The listener of a replay: counts what is published until the replayer says it has finished."""

from collections import Counter
from collections.abc import Callable
from typing import Any

from bathbot_depthcorr.node.stage_node import ERROR
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data

from bathbot_bringup.bag.message_types import message_class
from bathbot_bringup.bag.replaying.replayer import ReplayTopic, counted
from bathbot_bringup.bag.replaying.replayer_node import FINISHED, offered_again

MADE = {
    "skin_regions": "vision_msgs/msg/Detection2DArray",
    "contact_targets": "bathbot_msgs/msg/ContactTargets",
    "depth/corrected/camera_info": "sensor_msgs/msg/CameraInfo",
    "surface": "sensor_msgs/msg/PointCloud2",
    "planned_path": "nav_msgs/msg/Path",
}
"""What the pipeline may make: topic and type."""


class ReplayCounter:
    """Counts messages, and the regions and targets inside them.

    Attributes:
        counts: Messages by topic, and by topic and region.
        complaints: What each node last complained about; empty when all was well.
        finished: Whether the replayer has said that the bag is at its end.
        broken: Why it cannot go on; empty while it can.
    """

    def __init__(self, node: Node, topics: list[ReplayTopic]) -> None:
        """Subscribe, with a node that somebody spins, to what the replayer and the pipeline publish."""
        self.counts: Counter[str] = Counter()
        self.complaints: dict[str, str] = {}
        self.finished, self.broken = False, ""
        kinds = {f"/{name}": (kind, qos_profile_sensor_data) for name, kind in MADE.items()}
        kinds |= {topic.name: (topic.message_type, offered_again(topic)) for topic in counted(topics)}
        for name, (kind, qos) in kinds.items():
            raw = kind not in (MADE["skin_regions"], MADE["contact_targets"])
            node.create_subscription(message_class(kind), name, self._count(name), qos, raw=raw)
        node.create_subscription(DiagnosticArray, "/diagnostics", self._hear, QoSProfile(depth=50))

    def _count(self, name: str) -> Callable[[Any], None]:
        def count(message: Any) -> None:
            self.counts[name] += 1
            for detection in getattr(message, "detections", ()):
                self.counts[f"{name}: {detection.results[0].hypothesis.class_id}"] += 1
            for target in getattr(message, "targets", ()):
                self.counts[f"{name}: {target.region}"] += 1

        return count

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.complaints[status.name] = status.message if status.level != b"\x00" else ""
            if status.name == "replayer":
                self.finished |= status.message == FINISHED
                self.broken = status.message if status.level == ERROR else ""
