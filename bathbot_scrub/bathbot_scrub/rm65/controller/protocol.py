"""The controller's JSON frames: CRLF framing and integer units, both ways, without any socket.

All numbers on the wire are integers: joints 0.001 deg, lengths 0.001 mm, angles 0.001 rad, quaternions
(w, x, y, z) 1e-6, forces 0.001 N, torques 0.001 Nm. Frames end with CRLF only: the vendor's own
software sends bare line feeds inside a frame.
"""

import json
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.errors import ProtocolError

Array = NDArray[np.float64]
Frame = dict[str, Any]

MAX_FRAME = 65536  # [bytes]; the largest honest frame is below 2000
END = b"\r\n"
_LARGEST = 2**31  # no honest number on the wire is larger
_JOINT_UNIT = np.pi / 180.0 / 1000.0


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is not JSON")


class FrameBuffer:
    """Cuts a byte stream into frames; bytes may arrive in any pieces."""

    def __init__(self, limit: int = MAX_FRAME) -> None:
        """Refuse frames above `limit` [bytes]."""
        self._limit = limit
        self._pending = bytearray()

    def feed(self, data: bytes) -> Iterator[Frame | ProtocolError]:
        """Take bytes; give each complete frame, or the error of a bad one, in order.

        A bad frame is given as an error and skipped: the stream goes on behind its CRLF.

        Raises:
            ProtocolError: When the end of a frame does not come; the connection must be closed.
        """
        self._pending += data
        while (cut := self._pending.find(END)) >= 0:
            raw = bytes(self._pending[:cut])
            del self._pending[: cut + len(END)]
            if not raw.strip():
                continue
            try:
                yield decode(raw, self._limit)
            except ProtocolError as error:
                yield error
        if len(self._pending) > self._limit:
            size = len(self._pending)
            self._pending.clear()
            raise ProtocolError(f"no end of frame within {size} bytes; is the other side an RM65 controller?")


def decode(raw: bytes, limit: int = MAX_FRAME, constant: Callable[[str], float] = _refuse_constant) -> Frame:
    """Read one frame without its CRLF; `constant` reads NaN and Infinity, which are not JSON.

    Raises:
        ProtocolError: When it is too long, not UTF-8, not JSON, or not an object.
    """
    if len(raw) > limit:
        raise ProtocolError(f"frame of {len(raw)} bytes is longer than {limit}")
    try:
        frame = json.loads(raw.decode("utf-8"), parse_constant=constant)
    except (UnicodeDecodeError, ValueError, RecursionError) as error:
        raise ProtocolError(f"frame {raw[:60]!r} is not JSON: {type(error).__name__}") from error
    if not isinstance(frame, dict):
        raise ProtocolError(f"frame {raw[:60]!r} is not a JSON object")
    return frame


def encode(frame: Frame) -> bytes:
    """Write one frame with its CRLF."""
    return json.dumps(frame, separators=(",", ":"), allow_nan=False).encode() + END


def integers(frame: Frame, key: str, count: int) -> Array:
    """Read `count` numbers at `key` of a frame, still in wire units, shape (count,).

    Raises:
        ProtocolError: When they are missing, too few or many, not numbers, or beyond all sense.
    """
    values = frame.get(key)
    good = isinstance(values, list) and len(values) == count
    if not (good and all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)):
        raise ProtocolError(f"{key} must be {count} numbers, got {str(values)[:60]}")
    if not all(abs(v) < _LARGEST for v in values):
        raise ProtocolError(f"{key} holds a number out of range: {str(values)[:60]}")
    return np.array(values, dtype=float)


def integer(frame: Frame, key: str, lower: int, upper: int) -> int:
    """Read one number at `key`, refused unless lower <= number <= upper."""
    value = frame.get(key)
    if not isinstance(value, int | float) or isinstance(value, bool) or not lower <= value <= upper:
        raise ProtocolError(f"{key} must be a number from {lower} to {upper}, got {str(value)[:60]}")
    return int(value)


def joints_to_wire(joints: ArrayLike) -> list[int]:
    """Joint angles [rad] -> 0.001 deg."""
    return _rounded(joints, 1.0 / _JOINT_UNIT)


def joints_from_wire(values: ArrayLike) -> Array:
    """Joint angles 0.001 deg -> [rad]."""
    return np.asarray(values, dtype=float) * _JOINT_UNIT


def wrench_to_wire(wrench: ArrayLike) -> list[int]:
    """Forces and torques [N, Nm] -> 0.001 N, 0.001 Nm."""
    return _rounded(wrench, 1e3)


def wrench_from_wire(values: ArrayLike) -> Array:
    """Forces and torques 0.001 N, 0.001 Nm -> [N, Nm]."""
    return np.asarray(values, dtype=float) * 1e-3


def pose_to_wire(T: ArrayLike) -> list[int]:
    """A transform (4, 4) -> [x, y, z in 0.001 mm, rx, ry, rz in 0.001 rad], R = Rz Ry Rx."""
    T = np.asarray(T, dtype=float)
    return _rounded(T[:3, 3], 1e6) + _rounded(euler_from_rotation(T[:3, :3]), 1e3)


def pose_from_wire(values: ArrayLike) -> Array:
    """[x, y, z in 0.001 mm, rx, ry, rz in 0.001 rad] -> transform, shape (4, 4)."""
    values = np.asarray(values, dtype=float)
    T = np.eye(4)
    T[:3, :3] = rotation_from_euler(values[3:] * 1e-3)
    T[:3, 3] = values[:3] * 1e-6
    return T


def quaternion_to_wire(rotation: ArrayLike) -> list[int]:
    """A rotation matrix (3, 3) -> (w, x, y, z) in 1e-6, w not negative.

    In plain floats, a tenth of what a library's check of the matrix takes: it is sent 200 times a second.
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = np.asarray(rotation, dtype=float).tolist()
    # each component from the diagonal, its sign from the others
    squares = (1 + r00 + r11 + r22, 1 + r00 - r11 - r22, 1 - r00 + r11 - r22, 1 - r00 - r11 + r22)
    largest = max(range(4), key=squares.__getitem__)
    products = (
        (squares[0], r21 - r12, r02 - r20, r10 - r01),
        (r21 - r12, squares[1], r10 + r01, r02 + r20),
        (r02 - r20, r10 + r01, squares[2], r21 + r12),
        (r10 - r01, r02 + r20, r21 + r12, squares[3]),
    )[largest]
    return _rounded(products, math.copysign(0.5e6 / math.sqrt(squares[largest]), products[0]))


def quaternion_from_wire(values: ArrayLike) -> Array:
    """(w, x, y, z) in 1e-6 -> rotation matrix, shape (3, 3); the zero quaternion is refused."""
    w, x, y, z = map(float, values)
    square = w * w + x * x + y * y + z * z
    if not square > 0.25e12:
        raise ProtocolError(f"quaternion {[w, x, y, z]} is not of unit length in steps of 1e-6")
    twice = 2.0 / square  # by hand: two hundred times a second, scipy's Rotation takes seven times as long
    return np.array(
        [
            [1.0 - twice * (y * y + z * z), twice * (x * y - z * w), twice * (x * z + y * w)],
            [twice * (x * y + z * w), 1.0 - twice * (x * x + z * z), twice * (y * z - x * w)],
            [twice * (x * z - y * w), twice * (y * z + x * w), 1.0 - twice * (x * x + y * y)],
        ]
    )


def euler_from_rotation(rotation: ArrayLike) -> Array:
    """Angles (rx, ry, rz) [rad] of R = Rz(rz) Ry(ry) Rx(rx), shape (3,)."""
    R = np.asarray(rotation, dtype=float)
    rx = np.arctan2(R[2, 1], R[2, 2])
    s, c = np.sin(rx), np.cos(rx)
    # what is left behind rx: at ry = 90 deg, where rx may be anything, the three still make R
    rz = np.arctan2(s * R[0, 2] - c * R[0, 1], c * R[1, 1] - s * R[1, 2])
    return np.array([rx, np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0])), rz])


def rotation_from_euler(angles: ArrayLike) -> Array:
    """R = Rz(rz) Ry(ry) Rx(rx), shape (3, 3), of angles (rx, ry, rz) [rad]."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    return np.array(
        [
            [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx],
        ]
    )


def _rounded(values: ArrayLike, scale: float) -> list[int]:
    return [round(float(value) * scale) for value in np.ravel(values)]
