"""Node `replayer`: a bag -> its topics, bytes and time stamps as they were recorded."""

import threading
from pathlib import Path

from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import ERROR, OK, StageNode
from builtin_interfaces.msg import Time
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.interfaces import QosDurability, QosReliability
from rosgraph_msgs.msg import Clock

from bathbot_bringup.bag.message_types import message_class
from bathbot_bringup.bag.reading import check_whole
from bathbot_bringup.bag.recording.privacy import PICTURE_TYPES
from bathbot_bringup.bag.replaying.replay_settings import ReplayerSettings
from bathbot_bringup.bag.replaying.replayer import (
    ClockHands,
    ReplayTopic,
    choose_topics,
    messages_of,
    pace,
    wait_for_listeners,
)
from bathbot_bringup.errors import BringupError, SettingsError

FINISHED = "replay finished"
_ROOM, _PICTURES = 1000, 10  # messages that wait for a listener


def offered_again(topic: ReplayTopic) -> QoSProfile:
    """Offer a topic as it was offered when it was recorded, with room for listeners that are held up."""
    room = _PICTURES if topic.message_type in PICTURE_TYPES else _ROOM
    latched = topic.qos is not None and topic.qos.durability == QosDurability.TRANSIENT_LOCAL
    best_effort = topic.qos is not None and topic.qos.reliability == QosReliability.BEST_EFFORT
    return QoSProfile(
        depth=min(max(topic.messages, 1), room),
        reliability=ReliabilityPolicy.BEST_EFFORT if best_effort else ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


class ReplayerNode(StageNode):
    """Publishes in a thread of its own; says `replay finished` on /diagnostics at the end."""

    def __init__(self) -> None:
        """Declare the parameters."""
        super().__init__("replayer", ReplayerSettings)

    def setup(self, settings: ReplayerSettings) -> None:
        """Look into the bag and offer its topics."""
        if not settings.bag:
            raise SettingsError(
                "bag is empty, so there is nothing to replay; give a rosbag2 folder or an .mcap file"
            )
        self._settings = settings
        check_whole(Path(settings.bag))
        self._topics = choose_topics(Path(settings.bag), settings.sources_only)
        self._outputs = {
            topic.name: self.publisher(message_class(topic.message_type), topic.name, offered_again(topic))
            for topic in self._topics
        }
        self._clock_topic = self.publisher(Clock, "/clock", 10) if settings.clock else None

    def start(self) -> None:
        """Begin to publish."""
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._work, name="replay")
        self._thread.start()

    def stop(self) -> None:
        """Publish no more."""
        self._ended.set()
        self._thread.join()

    def _work(self) -> None:
        try:
            self._replay()
        except BringupError as error:
            self.get_logger().error(str(error))
            self.report(ERROR, str(error))

    def _replay(self) -> None:
        wait_for_listeners(self._is_heard, self._settings.wait_for_listeners, self._ended.wait)
        total = sum(topic.messages for topic in self._topics)
        self.report(OK, f"replaying {total} messages")
        messages, hands = messages_of(Path(self._settings.bag), self._topics), ClockHands()
        sent = 0
        for message in pace(messages, self._settings.rate, self._ended.wait):
            if self._clock_topic is not None and hands.move(message.time):
                seconds, rest = divmod(message.time, 10**9)
                self._clock_topic.publish(Clock(clock=Time(sec=seconds, nanosec=rest)))
            self._outputs[message.topic].publish(message.data)
            sent += 1
        if not self._ended.is_set():
            self.report(OK, FINISHED, messages=sent)
            self.get_logger().info(f"{FINISHED}: {sent} messages")

    def _is_heard(self) -> bool:
        return any(publisher.get_subscription_count() for publisher in self._outputs.values())


def main() -> None:
    """Run the node."""
    run(ReplayerNode)


if __name__ == "__main__":
    main()
