"""Images as they come over the wire (CDR), read in place: no copy of the pixels is made.

rclpy copies a picture of 1280x720 twice on its way into a message object; a node that only looks at the
pixels subscribes with `raw=True` and reads the bytes here.
"""

import struct
from typing import NamedTuple

from bathbot_depthcorr.errors import DepthcorrError

_HEAD = 4  # bytes of the encapsulation, which say the byte order; alignment counts from behind them


class SerializedImageError(DepthcorrError):
    """Bytes that are no sensor_msgs/Image."""


class Stamp(NamedTuple):
    """The fields of builtin_interfaces/Time."""

    sec: int
    nanosec: int


class ImageHeader(NamedTuple):
    """The fields of std_msgs/Header."""

    stamp: Stamp
    frame_id: str


class SerializedImage(NamedTuple):
    """The fields of sensor_msgs/Image; `data` is a view of the bytes that were read."""

    header: ImageHeader
    height: int
    width: int
    encoding: str
    is_bigendian: int
    step: int
    data: memoryview


class _Reader:
    """Reads one value after the other from CDR, each aligned to its size."""

    def __init__(self, message: bytes) -> None:
        if len(message) < _HEAD or message[0] != 0 or message[1] > 1:
            raise SerializedImageError(f"{len(message)} bytes are no CDR message; is the topic an Image?")
        self._order = "<" if message[1] else ">"
        self.rest, self.place = memoryview(message)[_HEAD:], 0

    def number(self, kind: str, size: int) -> int:
        self.place += -self.place % size
        try:
            (value,) = struct.unpack_from(self._order + kind, self.rest, self.place)
        except struct.error as error:
            raise self._cut_off() from error
        self.place += size
        return value

    def block(self) -> memoryview:
        size = self.number("I", 4)
        found = self.rest[self.place : self.place + size]
        if len(found) < size:
            raise self._cut_off()
        self.place += size
        return found

    def text(self) -> str:
        return bytes(self.block()).rstrip(b"\0").decode("utf-8", "replace")

    def stamp(self) -> Stamp:
        return Stamp(self.number("i", 4), self.number("I", 4))

    def _cut_off(self) -> SerializedImageError:
        return SerializedImageError(f"an Image of {len(self.rest) + _HEAD} bytes is cut off")


def read_image(message: bytes) -> SerializedImage:
    """Read a serialized sensor_msgs/Image.

    Raises:
        SerializedImageError: If the bytes are something else or cut off.
    """
    reader = _Reader(message)
    header = ImageHeader(reader.stamp(), reader.text())
    height, width = reader.number("I", 4), reader.number("I", 4)
    encoding, is_bigendian, step = reader.text(), reader.number("B", 1), reader.number("I", 4)
    return SerializedImage(header, height, width, encoding, is_bigendian, step, reader.block())


def stamp_of(message: bytes) -> float:
    """Time [s] in the header that a serialized message begins with.

    Raises:
        SerializedImageError: If the bytes are no message.
    """
    stamp = _Reader(message).stamp()
    return stamp.sec + 1e-9 * stamp.nanosec
