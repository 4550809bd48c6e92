"""Messages as bytes, worked on by a thread of their own; taking them leaves the control loop alone."""

import threading
from collections.abc import Callable

from bathbot_depthcorr.node.raw_subscription_node import RawSubscription
from bathbot_depthcorr.node.stage_node import StageNode
from rclpy.qos import QoSProfile

_LOOK = 0.1  # [s] between looks whether it is over


class RawListener:
    """A subscription, and the thread that works on what comes, in order; the rest waits in the middleware."""

    def __init__(
        self,
        node: StageNode,
        message_type: type,
        topic: str,
        qos: QoSProfile,
        most: int,
        work: Callable[[bytes], None],
        refuse: Callable[[int], None],
    ) -> None:
        """Listen for as long as the present phase of `node` lasts.

        Args:
            node: Owns the subscription.
            message_type: Of the topic.
            topic: Its name.
            qos: Its depth says how many messages may wait while `work` works; the newest are kept.
            most: Largest message [bytes].
            work: Called with a message; must not raise.
            refuse: Called with the size of a message that was too large [bytes].
        """
        self._work, self._refuse = work, refuse
        self._subscription = RawSubscription(node, message_type, topic, qos, most)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run, name=topic, daemon=True)
        self._thread.start()
        node.hold(self)

    def close(self) -> None:
        """End the thread, after the message in work."""
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._over.is_set():
            taken = self._subscription.take()
            if taken is None:
                self._subscription.waiting(_LOOK)
            elif taken.data:
                self._work(taken.data)
            else:
                self._refuse(taken.size)
