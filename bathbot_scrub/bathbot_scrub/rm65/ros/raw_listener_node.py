"""Messages as bytes, taken by a thread of their own, while the interpreter is free for others.

rclpy takes a message with the interpreter's lock held, 20 to 60 ms for a cloud of a million points, and the
control loop waits as long. rcl itself, asked by ctypes, needs no lock; and what is larger than it may be is
dropped there, without becoming an object.
"""

import ctypes
import threading
from collections.abc import Callable

from bathbot_depthcorr.node.stage_node import StageNode
from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.qos import QoSProfile

_POLL = 0.005  # [s] between looks whether something has come
_rcl, _rcutils = ctypes.CDLL("librcl.so"), ctypes.CDLL("librcutils.so")  # loaded by rclpy already


class _Allocator(ctypes.Structure):
    """`rcutils_allocator_t`."""

    _fields_ = tuple(
        (name, ctypes.c_void_p) for name in ("allocate", "deallocate", "reallocate", "zero_allocate", "state")
    )


class _Bytes(ctypes.Structure):
    """`rcl_serialized_message_t`."""

    _fields_ = (
        ("buffer", ctypes.c_void_p),
        ("length", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
        ("allocator", _Allocator),
    )


_rcutils.rcutils_get_default_allocator.restype = _Allocator
_rcl.rcl_take_serialized_message.argtypes = [ctypes.c_void_p] * 4


class _NoExecutor(CallbackGroup):
    """What belongs to it is left alone by every executor."""

    def can_execute(self, entity: object) -> bool:
        """Never."""
        return False

    def beginning_execution(self, entity: object) -> bool:
        """Never."""
        return False

    def ending_execution(self, entity: object) -> None:
        """Never begun."""


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
        self._most, self._work, self._refuse = most, work, refuse
        self._group, self._over = _NoExecutor(), threading.Event()
        subscription = node.listen(message_type, topic, work, qos, raw=True, group=self._group)
        self._handle = subscription.handle
        self._thread = threading.Thread(target=self._run, name=topic, daemon=True)
        self._thread.start()
        node.hold(self)

    def close(self) -> None:
        """End the thread, after the message in work."""
        self._over.set()
        self._thread.join(2.0)

    def _run(self) -> None:
        while not self._over.is_set():
            try:
                raw = self._take()
            except InvalidHandle:  # the subscription ends before its thread
                return
            if raw is None:
                self._over.wait(_POLL)
            else:
                self._work(raw)

    def _take(self) -> bytes | None:
        """The next message that is not too large; None when there is none."""
        taken = _Bytes(allocator=_rcutils.rcutils_get_default_allocator())
        try:
            with self._handle:  # it lives until then
                if _rcl.rcl_take_serialized_message(self._handle.pointer, ctypes.byref(taken), None, None):
                    return None
            if taken.length <= self._most:
                return ctypes.string_at(taken.buffer, taken.length)
        finally:
            _rcutils.rcutils_uint8_array_fini(ctypes.byref(taken))
        self._refuse(taken.length)
        return None
