"""The listener of a replay: counts what is published until the replayer says it has finished."""

from collections import Counter
from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import QoSProfile, qos_profile_sensor_data

from bathbot_bringup.bag.reading import bag_length
from bathbot_bringup.bag.replay_settings import ReplaySettings
from bathbot_bringup.bag.replayer import ReplayTopic
from bathbot_bringup.bag.replayer_node import FINISHED
from bathbot_bringup.errors import ProcessError
from bathbot_bringup.graph.client_node import GraphClient
from bathbot_bringup.graph.message_types import message_class
from bathbot_bringup.graph.node_table import find_node, node_command
from bathbot_bringup.graph.processes import ProcessGroup

MADE = {
    "skin_regions": "vision_msgs/msg/Detection2DArray",
    "contact_targets": "bathbot_msgs/msg/ContactTargets",
    "depth/corrected/camera_info": "sensor_msgs/msg/CameraInfo",
    "surface": "sensor_msgs/msg/PointCloud2",
    "planned_path": "nav_msgs/msg/Path",
}
"""What the pipeline may make: topic and type."""
_LAST_WORDS = 2.0  # [s] for what is still being worked on


class _Counter:
    """Counts messages, and the regions and targets inside them."""

    def __init__(self, client: GraphClient, topics: list[ReplayTopic]) -> None:
        self.counts: Counter[str] = Counter()
        self.complaints: dict[str, str] = {}
        self.finished = False
        node = client.node
        kinds = {f"/{name}": kind for name, kind in MADE.items()}
        kinds |= {
            topic.name: topic.message_type for topic in topics if not topic.message_type.endswith("/Image")
        }
        for name, kind in kinds.items():
            raw = kind not in (MADE["skin_regions"], MADE["contact_targets"])
            node.create_subscription(
                message_class(kind), name, self._count(name), qos_profile_sensor_data, raw=raw
            )
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
            self.finished |= status.name == "replayer" and status.message == FINISHED


def watch_replay(
    group: ProcessGroup,
    domain: int,
    settings: ReplaySettings,
    topics: list[ReplayTopic],
    start: float,
    slack: float,
) -> tuple[dict[str, int], dict[str, str]]:
    """Wait until the pipeline is active, start the replayer and count until it has finished.

    Args:
        group: The pipeline's processes.
        domain: DDS domain of the replay.
        settings: Of the replay.
        topics: What will be published.
        start: Time for the nodes to be active [s].
        slack: Time beyond the length of the bag [s].

    Returns:
        Messages by topic, and what the nodes last complained about, by node.

    Raises:
        ProcessError: When a process dies or the replay does not end.
    """
    with GraphClient("bathbot_replay", domain) as client:
        group.wait_until(client.is_active, start)
        counter = _Counter(client, topics)
        _start_replayer(group, settings)
        client.watch = group.check
        patience = bag_length(settings.bag) / settings.rate + slack
        if not client.spin_until(lambda: counter.finished, patience):
            raise ProcessError("replayer", f"did not finish within {patience:.0f} s", "", "the nodes' logs")
        client.spin_until(lambda: False, _LAST_WORDS)
        return dict(counter.counts), counter.complaints


def _start_replayer(group: ProcessGroup, settings: ReplaySettings) -> None:
    """Start the node that publishes, once the others listen."""
    entry = find_node("replayer")
    group.start(entry.name, node_command(entry, settings.parameters("replayer")), entry.niceness)
