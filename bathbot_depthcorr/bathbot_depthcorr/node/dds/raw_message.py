"""A message of ROS taken as bytes, and what rclpy keeps to itself: who sent it.

rclpy takes a message with the interpreter's lock held, 20 to 60 ms for a cloud of a million points, and a
control loop would wait as long. rcl itself, asked by ctypes, needs no lock; what is larger than it may be is
dropped there, without becoming an object.
"""

import ctypes
from typing import NamedTuple

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


class _Info(ctypes.Structure):
    """`rmw_message_info_t`."""

    _fields_ = (
        ("source_timestamp", ctypes.c_int64),
        ("received_timestamp", ctypes.c_int64),
        ("publication_sequence_number", ctypes.c_uint64),
        ("reception_sequence_number", ctypes.c_uint64),
        ("implementation", ctypes.c_char_p),
        ("publisher", ctypes.c_ubyte * 16),
        ("from_intra_process", ctypes.c_bool),
    )


_rcutils.rcutils_get_default_allocator.restype = _Allocator
_rcl.rcl_take_serialized_message.argtypes = [ctypes.c_void_p] * 4
_rcl.rcl_subscription_set_on_new_message_callback.argtypes = [ctypes.c_void_p] * 3
# (file, number) as the callback's (data, number): the kernel wakes who waits, and Python is not asked
_write = ctypes.cast(ctypes.CDLL(None).eventfd_write, ctypes.c_void_p)


class Taken(NamedTuple):
    """A message as it came.

    Attributes:
        size: Of the message [bytes].
        data: CDR; empty when it was larger than it may be.
        published: When it was sent, by its publisher's clock [ns].
        number: Its publisher's count.
        publisher: Which one of the topic.
    """

    size: int
    data: bytes
    published: int
    number: int
    publisher: bytes


def tell(subscription: int, event: int | None) -> None:
    """Have each message that comes raise an eventfd, in the middleware's own thread; None ends that.

    Args:
        subscription: Address of the `rcl_subscription_t`.
        event: Descriptor of the eventfd.
    """
    _rcl.rcl_subscription_set_on_new_message_callback(subscription, None if event is None else _write, event)


def take(subscription: int, most: int) -> Taken | None:
    """The next message that waits; None when there is none.

    Args:
        subscription: Address of the `rcl_subscription_t`, which must live until this returns.
        most: Largest message that is given [bytes].
    """
    taken, info = _Bytes(allocator=_rcutils.rcutils_get_default_allocator()), _Info()
    try:
        if _rcl.rcl_take_serialized_message(subscription, ctypes.byref(taken), ctypes.byref(info), None):
            return None
        return Taken(
            taken.length,
            b"" if taken.length > most else ctypes.string_at(taken.buffer, taken.length),
            info.source_timestamp,
            info.publication_sequence_number,
            bytes(info.publisher),
        )
    finally:
        _rcutils.rcutils_uint8_array_fini(ctypes.byref(taken))
