"""The controller's UDP state push at up to 200 Hz: one datagram, one `ArmSample`.

The force vector has no stamp of its own, so a sample is stamped on arrival.
"""

import ctypes
import math
import socket
import threading
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.errors import ArmConnectionError, ProtocolError
from bathbot_scrub.rm65.controller.protocol import (
    Frame,
    decode,
    integers,
    joints_from_wire,
    quaternion_from_wire,
    wrench_from_wire,
)
from bathbot_scrub.rm65.controller.push_source import LEARN, PushRate, PushSource
from bathbot_scrub.rm65.timing.clock import MONOTONIC
from bathbot_scrub.rm65.timing.priority import raise_priority

Array = NDArray[np.float64]
_MAX_DATAGRAM = 65535
_DISABLED = 0x0010  # error bit of a joint that has not started
_LOOPBACK = "127.0.0.1"
_POLL = 0.2  # [s] between looks at the stop flag
_REST = 0.001  # [s] after a datagram that is not wanted: a flood of them must not keep the interpreter busy
CYCLE = 0.005  # [s] of the push, as it is ordered
_LIBC = ctypes.CDLL(None)
_NOBODY = bytes(16)  # an address of no family: to it a socket is connected that shall hear everybody again


class ArmSample(NamedTuple):
    """What the controller measured at one instant."""

    stamp: float  # [s] on arrival
    joints: Array  # [rad], shape (6,)
    raw_wrench: Array  # [N, Nm], shape (6,), as measured, with weight and bias, sensor frame
    wrench: Array  # the same: external force at the sensor after zeroing
    T_base_flange: Array  # (4, 4), as the controller computes it
    errors: tuple[int, ...]  # codes of the controller that are not zero
    joint_errors: tuple[int, ...]  # error bits of each joint, as far as the controller tells them
    status: str  # the controller's word for what it does


def parse_sample(raw: bytes, stamp: float) -> ArmSample:
    """Read one datagram; a force that is no six numbers becomes NaN, for the joints count all the same.

    Raises:
        ProtocolError: When it is not a complete joint state.
    """
    frame = decode(raw.rstrip(b"\r\n"), constant=float)
    if frame.get("state") != "realtime_arm_joint_state":
        raise ProtocolError(f"datagram is no joint state but {str(frame.get('state'))[:40]!r}")
    status = _part(frame, "joint_status")
    joints = joints_from_wire(integers(status, "joint_position", 6))
    sensor = _part(frame, "six_force_sensor")
    waypoint = _part(frame, "waypoint")
    T = np.eye(4)
    T[:3, 3] = integers(waypoint, "position", 3) * 1e-6
    T[:3, :3] = quaternion_from_wire(integers(waypoint, "quat", 4))
    word = str(frame.get("arm_current_status", ""))[:40]
    wrenches = _wrench(sensor, "force"), _wrench(sensor, "zero_force")
    return ArmSample(stamp, joints, *wrenches, T, _errors(frame), _joint_errors(status), word)


def clearing(sample: ArmSample | None) -> list[tuple[Frame, str]]:
    """Commands that clear the errors of a sample, each with the key of its reply that says so."""
    bits = () if sample is None else sample.joint_errors
    joints = [number for number, code in enumerate(bits, 1) if code]
    return [
        ({"command": "clear_system_err"}, "clear_state"),
        *(
            ({"command": "set_joint_clear_err", "joint_clear_err": joint}, "joint_clear_err")
            for joint in joints
        ),
    ]


def _wrench(sensor: Frame, key: str) -> Array:
    try:
        return wrench_from_wire(integers(sensor, key, 6))
    except ProtocolError:
        return np.full(6, np.nan)


def _part(frame: Frame, key: str) -> Frame:
    part = frame.get(key)
    if not isinstance(part, dict):
        raise ProtocolError(f"joint state lacks {key}; enable it in the controller's realtime push")
    return part


def _errors(frame: Frame) -> tuple[int, ...]:
    """Collect the error codes that are not zero, whatever shape this firmware gives them."""
    listed = frame.get("err", [])
    codes = listed if isinstance(listed, list) else [listed]
    codes = [*codes, frame.get("arm_err", 0), frame.get("sys_err", 0)]
    numbers = (_code(code) for code in codes)
    return tuple(dict.fromkeys(number for number in numbers if number))


def _joint_errors(status: Frame) -> tuple[int, ...]:
    """Error bits of the joints; a joint that says it is disabled has bit 0x10, start."""
    bits, enabled = status.get("joint_err_code", [0] * 6), status.get("joint_en_flag", [1] * 6)
    bits = bits if isinstance(bits, list) else [-1]
    found = [_code(code) & 0xFFFF for code in bits[:6]]
    if isinstance(enabled, list) and len(enabled) == len(found):
        found = [
            code if flag in (1, True) else code | _DISABLED for code, flag in zip(found, enabled, strict=True)
        ]
    return tuple(found)


def _code(code: object) -> int:
    """One code as a number; what cannot be read is not healthy: -1."""
    try:
        return int(code, 16) if isinstance(code, str) else int(code)  # type: ignore[call-overload]
    except (TypeError, ValueError, OverflowError):
        return -1


def _bound(address: str, port: int) -> socket.socket:
    """A socket that keeps its port when it shall hear everybody again: it was asked for by number."""
    opened = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        opened.bind((address, port))
        opened.settimeout(_POLL)
        if port:
            return opened
        free = int(opened.getsockname()[1])
    except OSError as error:
        opened.close()
        message = f"cannot listen on UDP port {port} of {address}: {error}; choose another udp_port"
        raise ArmConnectionError(message) from error
    opened.close()
    return _bound(address, free)


class StateReceiver:
    """Receives the push in a thread of its own and keeps the newest sample."""

    def __init__(
        self,
        port: int,
        on_sample: Callable[[ArmSample], None],
        on_refusal: Callable[[], None] = lambda: None,
        on_excess: Callable[[], None] = lambda: None,
        learn: float = LEARN,
        clock: Callable[[], float] = MONOTONIC,
    ) -> None:
        """Open the port (0: any free one) on loopback and start; nobody is believed before `expect`.

        Args:
            port: UDP port.
            on_sample: Called in the receiving thread with every good sample.
            on_refusal: Called there for every datagram of the controller that is none.
            on_excess: Called there for every datagram beyond the rate that was ordered.
            learn: Time for which senders are looked at before one is believed [s].
            clock: Stamps the samples [s].

        Raises:
            ArmConnectionError: When the port cannot be opened.
        """
        self._socket = _bound(_LOOPBACK, port)
        self._next: socket.socket | None = None  # to take when the thread comes round
        self._address, self.port = self._socket.getsockname()
        self.accepted = 0
        self.rejected = 0
        self.last_error = ""
        self.latest: ArmSample | None = None
        self.source, self._rate, self._turning = PushSource(learn), PushRate(1.0 / CYCLE), threading.Lock()
        self._on_sample, self._on_refusal, self._on_excess = on_sample, on_refusal, on_excess
        self._clock, self._open = clock, True
        self._thread = threading.Thread(target=self._receive, name="rm65-push", daemon=True)
        self._thread.start()

    def listen_at(self, address: str) -> None:
        """Listen at that address of this machine from now on, and at no other.

        Raises:
            ArmConnectionError: When the port is taken there.
        """
        if address == self._address:
            return
        opened = _bound(address, self.port)
        with self._turning:
            if self._next is not None:
                self._next.close()
            self._next, self._address = opened, address

    def expect(self, address: str) -> None:
        """The push has been ordered from `address`: learn anew which port it comes from."""
        with self._turning:
            _LIBC.connect(self._socket.fileno(), _NOBODY, len(_NOBODY))
            self.source.expect(address)

    def age(self) -> float:
        """Time since the newest sample [s]; infinite before the first."""
        return math.inf if self.latest is None else self._clock() - self.latest.stamp

    def close(self) -> None:
        """Stop listening."""
        self._open = False
        self._thread.join(2.0 * _POLL + 1.0)
        self._move()
        self._socket.close()

    def _receive(self) -> None:
        raise_priority()  # what the control loop judges comes through here
        while self._open:
            self._move()
            try:
                raw, sender = self._socket.recvfrom(_MAX_DATAGRAM)
            except TimeoutError:
                continue
            except OSError as error:
                self.last_error = str(error)
                time.sleep(_POLL)
                continue
            now = self._clock()
            if not self._believes(sender, now):
                if not self.source.learning:
                    self.rejected += 1
                    self.last_error = f"datagram from {sender[0]}:{sender[1]}, not from the controller"
                time.sleep(_REST)
                continue
            if self._rate.exceeded(now):
                self.rejected += 1
                self.last_error = "more datagrams than were ordered"
                self._on_excess()
                time.sleep(_REST)
                continue
            try:
                sample = parse_sample(raw, now)
            except ProtocolError as error:
                self.rejected += 1
                self.last_error = str(error)
                self._on_refusal()
                continue
            self.accepted += 1
            self.latest = sample
            self._on_sample(sample)

    def _move(self) -> None:
        """Take the socket of another address, if there is one; what has come there meanwhile waits in it."""
        with self._turning:
            if self._next is not None:
                self._socket.close()
                self._socket, self._next = self._next, None

    def _believes(self, sender: tuple[str, int], now: float) -> bool:
        """Ask the source; once it knows its port, have the kernel drop what others send, unread."""
        with self._turning:
            known = self.source.believed is not None
            believed = self.source.believes(sender, now)
            if believed and not known:
                self._socket.connect(sender)
        return believed
