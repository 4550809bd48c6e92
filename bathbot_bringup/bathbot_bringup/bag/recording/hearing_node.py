"""The ears of the recorder: one thread takes what all topics have sent, as bytes, and hands it on."""

import select
import threading
import time

from bathbot_depthcorr.node.dds.raw_message import Taken
from bathbot_depthcorr.node.raw_subscription_node import RawSubscription
from bathbot_depthcorr.node.stage_node import StageNode
from rclpy.qos import QoSProfile

from bathbot_bringup.bag.recording.mcap_bag import Source, Stored
from bathbot_bringup.bag.recording.recorder import Recorder
from bathbot_bringup.bag.recording.sender_counts import SenderCounts

_TURN = 50  # messages of one topic before the others have their turn
_LAST = 1.0  # [s] for what has come before the end
_LOOK = 0.1  # [s] between looks whether it is over


class Hearing:
    """Lives as long as the present phase of its node."""

    def __init__(self, node: StageNode, recorder: Recorder) -> None:
        """Begin, with no topic yet."""
        self._node, self._recorder, self._counts = node, recorder, SenderCounts()
        self._heard: dict[int, tuple[Source, RawSubscription]] = {}  # by descriptor
        self._ready = select.epoll()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._work, name="hearing", daemon=True)
        self._thread.start()
        node.hold(self)

    def add(self, source: Source, kind: type, qos: QoSProfile, most: int) -> None:
        """Hear one more topic; a message of more than `most` bytes is refused unread."""
        ear = RawSubscription(self._node, kind, source.topic, qos, most)
        self._heard[ear.fileno()] = source, ear
        self._ready.register(ear, select.EPOLLIN)

    def close(self) -> None:
        """Take what has come, then end."""
        self._over.set()
        self._thread.join()
        self._ready.close()

    def _work(self) -> None:
        while not self._over.is_set():
            self._turn(_LOOK)
        deadline = time.monotonic() + _LAST
        while self._turn(0.0) and time.monotonic() < deadline:
            pass

    def _turn(self, seconds: float) -> bool:
        """Wait so long [s] for what comes and take it; whether anything came."""
        ready = self._ready.poll(seconds)
        for number, _ in ready:
            self._listen(*self._heard[number])
        return bool(ready)

    def _listen(self, source: Source, ear: RawSubscription) -> None:
        """Take what one topic has sent."""
        ear.waiting(0.0)
        for _ in range(_TURN):
            taken = ear.take()
            if taken is None:
                return
            self._hand_on(source, taken)
        ear.remind()

    def _hand_on(self, source: Source, taken: Taken) -> None:
        self._recorder.miss(self._counts.missed(source.topic, taken.publisher, taken.number))
        if taken.data:
            # the time of now: who reads a bag without an index needs its messages in order of time
            now = self._node.get_clock().now().nanoseconds
            self._recorder.put(Stored(source, now, taken.data, taken.published, taken.number))
        else:
            self._recorder.refuse(source, taken.size)
