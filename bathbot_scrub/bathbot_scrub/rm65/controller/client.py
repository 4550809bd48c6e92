"""A client of the controller's TCP/JSON protocol: requests, events, and the joint stream.

One request is in flight at a time and its reply is matched by name, for the protocol has no request
numbers. Joint frames of the stream need no reply and never wait for one. A lost connection is built
up again in the background with growing pauses.
"""

import socket
import struct
import threading
from collections.abc import Callable
from typing import NamedTuple

from numpy.typing import ArrayLike

from bathbot_scrub.arm.errors import ArmConnectionError, ProtocolError, RefusedError
from bathbot_scrub.rm65.controller.protocol import Frame, FrameBuffer, encode, joints_to_wire

REPLY_TIMEOUT = 0.5  # [s], the vendor's own
_CONNECT_TIMEOUT = 2.0  # [s]
_SEND_TIMEOUT = struct.pack("ll", 0, 100_000)  # 0.1 s as a timeval: a deaf peer must not hold the stream
_FIRST_PAUSE, _LONGEST_PAUSE = 0.2, 5.0  # [s] between attempts to connect

TRAJECTORY_EVENT = "current_trajectory_state"


class Connection(NamedTuple):
    """Whether the controller is reachable, and what stands in the way."""

    connected: bool
    reason: str  # one line; empty when connected


def stream_frame(joints: ArrayLike) -> Frame:
    """One frame of the high-follow joint stream, angles [rad], shape (6,)."""
    return {
        "command": "movej_canfd",
        "joint": joints_to_wire(joints),
        "follow": True,
        "expand": 0,
        "trajectory_mode": 0,
        "radio": 0,
    }


class ArmClient:
    """A connection to one controller that outlives its losses. Thread-safe."""

    def __init__(
        self,
        host: str,
        port: int,
        on_connection: Callable[[Connection], None] = lambda _: None,
        on_event: Callable[[Frame], None] = lambda _: None,
    ) -> None:
        """Remember where to connect to; `start` begins.

        Args:
            host: Address or name of the controller.
            port: TCP port, 8080 on a real one.
            on_connection: Called in the client's thread at every change.
            on_event: Called in the client's thread with frames nobody asked for, such as
                "current_trajectory_state".
        """
        self.host, self.port = host, port
        self.connection = Connection(False, "not yet connected")
        self.protocol_errors, self.last_error = 0, ""
        self._on_connection, self._on_event = on_connection, on_event
        self._socket: socket.socket | None = None
        self._sending, self._requesting = threading.Lock(), threading.Lock()
        self._reply = threading.Condition()
        self._awaited: tuple[str, ...] = ()
        self._answer: Frame | None = None
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._live, name="rm65-tcp", daemon=True)

    def start(self) -> None:
        """Begin to connect in the background."""
        self._thread.start()

    def request(self, frame: Frame, timeout: float = REPLY_TIMEOUT) -> Frame:
        """Send a command and wait for its reply.

        Raises:
            ArmConnectionError: Without connection, or without reply in time.
        """
        command = str(frame["command"])
        with self._requesting:
            with self._reply:
                # queries are answered by the name of the state, without "get_"
                self._awaited, self._answer = (command, command.removeprefix("get_")), None
            self._send(encode(frame))
            with self._reply:
                answered = self._reply.wait_for(
                    lambda: self._answer is not None or self._socket is None, timeout
                )
                answer, self._awaited = self._answer, ()
        if answer is None:
            what = f"no reply to {command} within {timeout} s" if not answered else "the connection was lost"
            raise ArmConnectionError(f"{self.host}:{self.port}: {what}; is it an RM65 controller?")
        return answer

    def demand(self, frame: Frame, key: str) -> None:
        """Send a command whose reply must hold `key`: true.

        Raises:
            RefusedError: When the controller refuses.
            ArmConnectionError: Without connection, or without reply in time.
        """
        answer = self.request(frame)
        if answer.get(key) is not True:
            raise RefusedError(
                f"the controller refused {frame['command']}: {str(answer)[:120]}; see its error list"
            )

    def post(self, frame: Frame) -> None:
        """Send a command and do not wait for its reply.

        Raises:
            ArmConnectionError: Without connection.
        """
        self._send(encode(frame))

    def stream_joints(self, joints: ArrayLike) -> None:
        """Send one frame of the high-follow joint stream, angles [rad], shape (6,); no reply comes.

        Raises:
            ArmConnectionError: Without connection.
        """
        self.post(stream_frame(joints))

    def local_address(self) -> str:
        """Our own address as the controller sees it.

        Raises:
            ArmConnectionError: Without connection.
        """
        return str(self._ask(lambda connected: connected.getsockname())[0])

    def controller_address(self) -> str:
        """Address from which the controller answers.

        Raises:
            ArmConnectionError: Without connection.
        """
        return str(self._ask(lambda connected: connected.getpeername())[0])

    def reconnect(self) -> None:
        """Give up the present connection, for the other side does not answer; a new one is built up."""
        self._drop()

    def close(self) -> None:
        """Close the connection and end the thread."""
        self._closing.set()
        self._drop()
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join(_CONNECT_TIMEOUT + 1.0)

    def _ask(self, question: Callable[[socket.socket], tuple[str, int]]) -> tuple[str, int]:
        connected = self._socket
        if connected is None:
            raise ArmConnectionError(f"{self.host}:{self.port}: {self.connection.reason}")
        try:
            return question(connected)
        except OSError as error:
            raise ArmConnectionError(f"{self.host}:{self.port}: {error}") from error

    def _send(self, data: bytes) -> None:
        with self._sending:
            connected = self._socket
            if connected is None:
                raise ArmConnectionError(f"{self.host}:{self.port}: {self.connection.reason}")
            try:
                connected.sendall(data)
            except OSError as error:
                self._drop()  # part of the frame may be out: this stream is spoilt
                raise ArmConnectionError(f"{self.host}:{self.port}: cannot send: {error}") from error

    def _live(self) -> None:
        """Connect, receive until the connection ends, pause, again."""
        pause = _FIRST_PAUSE
        while not self._closing.is_set():
            try:
                connected = socket.create_connection((self.host, self.port), _CONNECT_TIMEOUT)
            except (OSError, UnicodeError) as error:
                self._tell(
                    Connection(
                        False,
                        f"cannot reach the controller at {self.host}:{self.port} ({error}); "
                        "check parameters host and port, and the cable",
                    )
                )
                self._closing.wait(pause)
                pause = min(2.0 * pause, _LONGEST_PAUSE)
                continue
            pause = _FIRST_PAUSE
            connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connected.settimeout(None)
            connected.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _SEND_TIMEOUT)
            self._socket = connected
            self._tell(Connection(True, ""))
            reason = self._receive(connected)
            self._drop()
            if not self._closing.is_set():
                self._tell(Connection(False, f"lost the controller at {self.host}:{self.port}: {reason}"))
                self._closing.wait(pause)

    def _receive(self, connected: socket.socket) -> str:
        """Hand out frames until the connection ends; tell why it ended."""
        buffer = FrameBuffer()
        while True:
            try:
                data = connected.recv(65536)
                if not data:
                    return "closed by the controller"
                for frame in buffer.feed(data):
                    if isinstance(frame, ProtocolError):
                        self.protocol_errors, self.last_error = self.protocol_errors + 1, str(frame)
                    else:
                        self._sort(frame)
            except (OSError, ProtocolError) as error:
                return "given up, it did not answer" if self._socket is None else str(error)

    def _sort(self, frame: Frame) -> None:
        name = frame.get("command", frame.get("state"))
        with self._reply:
            if name in self._awaited and self._answer is None:
                self._answer = frame
                self._reply.notify_all()
                return
        self._on_event(frame)

    def _tell(self, connection: Connection) -> None:
        changed = connection != self.connection
        self.connection = connection
        if changed:
            self._on_connection(connection)

    def _drop(self) -> None:
        with self._reply:
            connected, self._socket = self._socket, None
            self._reply.notify_all()
        if connected is not None:
            try:
                connected.shutdown(socket.SHUT_RDWR)
            except OSError:
                connected.close()  # was dead already
            connected.close()
