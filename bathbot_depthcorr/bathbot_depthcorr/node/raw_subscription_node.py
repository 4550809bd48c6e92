"""A subscription whose messages are taken as bytes by whoever asks, not by an executor."""

import os
import select

from rclpy.callback_groups import CallbackGroup
from rclpy.qos import QoSProfile

from bathbot_depthcorr.node.dds import raw_message
from bathbot_depthcorr.node.dds.raw_message import Taken
from bathbot_depthcorr.node.endpoints_node import EndpointOwner
from bathbot_depthcorr.node.lifetime import Rank


class _NoExecutor(CallbackGroup):
    """What belongs to it is left alone by executors that heed groups: all but `EventsExecutor`."""

    def can_execute(self, entity: object) -> bool:
        """Never."""
        return False

    def beginning_execution(self, entity: object) -> bool:
        """Never."""
        return False

    def ending_execution(self, entity: object) -> None:
        """Never begun."""


class RawSubscription:
    """Lives as long as the present phase of its node."""

    def __init__(
        self, node: EndpointOwner, message_type: type, topic: str, qos: QoSProfile, most: int
    ) -> None:
        """Subscribe; the depth of `qos` says how many may wait to be taken, `most` how large one may be."""
        self._group, self._most = _NoExecutor(), most
        made = node.create_subscription(
            message_type, topic, self._never_called, qos, raw=True, callback_group=self._group
        )
        self._handle, self._event = made.handle, os.eventfd(0, os.EFD_CLOEXEC | os.EFD_NONBLOCK)
        with self._handle:
            raw_message.tell(self._handle.pointer, self._event)

        def end() -> None:
            with self._handle:
                raw_message.tell(self._handle.pointer, None)
            node.destroy_subscription(made)
            os.close(self._event)

        node.lifetime.keep(Rank.OUTLET, end)  # outlives who takes

    @staticmethod
    def _never_called(_: bytes) -> None:
        """No executor takes these messages."""

    def fileno(self) -> int:
        """Can be read, by `select` and its like, once something has come since the last `waiting`."""
        return self._event

    def waiting(self, seconds: float) -> bool:
        """Wait so long [s] until something comes; whether it did. Then take all there is."""
        if not select.select([self], [], [], seconds)[0]:
            return False
        os.eventfd_read(self._event)
        return True

    def remind(self) -> None:
        """Have `waiting` tell of what was left lying."""
        os.eventfd_write(self._event, 1)

    def take(self) -> Taken | None:
        """The next message; None when there is none.

        Raises:
            InvalidHandle: When the subscription has ended.
        """
        with self._handle:  # it lives until then
            return raw_message.take(self._handle.pointer, self._most)
