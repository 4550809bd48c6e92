"""The ears of the recorder: one thread takes what all topics have sent, as bytes, and hands it on."""

import threading
import time

from bathbot_depthcorr.node.dds.raw_message import Taken
from bathbot_depthcorr.node.raw_subscription_node import RawSubscription
from bathbot_depthcorr.node.stage_node import StageNode
from rclpy.qos import QoSProfile

from bathbot_bringup.bag.recording.mcap_bag import Source, Stored
from bathbot_bringup.bag.recording.recorder import Recorder
from bathbot_bringup.bag.recording.sender_counts import SenderCounts

_POLL = 0.002  # [s] between looks whether something has come
_TURN = 50  # messages of one topic before the others have their turn


class Hearing:
    """Lives as long as the present phase of its node."""

    def __init__(self, node: StageNode, recorder: Recorder) -> None:
        """Begin, with no topic yet."""
        self._node, self._recorder, self._counts = node, recorder, SenderCounts()
        self._heard: list[tuple[Source, RawSubscription]] = []
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work, name="hearing", daemon=True)
        self._thread.start()
        node.hold(self)

    def add(self, source: Source, kind: type, qos: QoSProfile, most: int) -> None:
        """Hear one more topic; a message of more than `most` bytes is refused unread."""
        self._heard.append((source, RawSubscription(self._node, kind, source.topic, qos, most)))

    def close(self) -> None:
        """Take what has come, then end."""
        self._over.set()
        self._thread.join()

    def _work(self) -> None:
        going = True
        while going:
            going = not self._over.is_set()
            shift = self._node.get_clock().now().nanoseconds - time.time_ns()  # to simulated time
            if not any([self._turn(source, ear, shift) for source, ear in self._heard.copy()]):
                self._over.wait(_POLL)

    def _turn(self, source: Source, ear: RawSubscription, shift: int) -> bool:
        """Take some messages of one topic; whether there may be more."""
        for _ in range(_TURN):
            taken = ear.take()
            if taken is None:
                return False
            self._hand_on(source, taken, shift)
        return True

    def _hand_on(self, source: Source, taken: Taken, shift: int) -> None:
        self._recorder.miss(self._counts.missed(source.topic, taken.publisher, taken.number))
        if taken.data:
            self._recorder.put(
                Stored(source, taken.received + shift, taken.data, taken.published, taken.number)
            )
        else:
            self._recorder.refuse(source, taken.size)
