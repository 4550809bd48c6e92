"""The emulated controller on the wire: a TCP server of the vendor's protocol and a 200 Hz UDP push.

Two threads: an asyncio loop answers the clients, a clocked thread moves the arm and pushes its state.
One lock stands around the controller.
"""

import asyncio
import logging
import threading
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from bathbot_scrub.rm65.errors import ArmConnectionError, ProtocolError
from bathbot_scrub.rm65.kinematics import Kinematics
from bathbot_scrub.rm65.limits import RM65_LIMITS
from bathbot_scrub.rm65.period import raise_priority
from bathbot_scrub.rm65.protocol import Frame, FrameBuffer, encode
from numpy.typing import NDArray

import bathbot_bringup.sim.controller_moves  # noqa: F401 - enters its commands into the table
from bathbot_bringup.sim.brush import Brush, Contact, SkinSurface
from bathbot_bringup.sim.controller import STEP, Arm, Controller, Settled
from bathbot_bringup.sim.controller_replies import Desk, reply
from bathbot_bringup.sim.emulator_settings import EmulatorSettings
from bathbot_bringup.sim.emulator_surface import NoSurface
from bathbot_bringup.sim.push import PushSender, PushSettings, datagram

Array = NDArray[np.float64]
log = logging.getLogger(__name__)
_MAX_UNREAD = 1 << 20  # [bytes] a client may leave unread before it is cut off


class Truth(NamedTuple):
    """What only a simulator knows."""

    T_base_head: Array  # (4, 4)
    contact: Contact
    joints: Array  # [rad], shape (6,)


class _Session(asyncio.Protocol):
    """One client."""

    def __init__(self, emulator: "Emulator") -> None:
        self._emulator, self._buffer = emulator, FrameBuffer()
        self._complained = False
        self.transport: asyncio.Transport

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = transport  # type: ignore[assignment]
        self._emulator.sessions.add(self)

    def connection_lost(self, exc: Exception | None) -> None:
        self._emulator.sessions.discard(self)

    def data_received(self, data: bytes) -> None:
        try:
            for frame in self._buffer.feed(data):
                if isinstance(frame, ProtocolError):
                    self._complain(frame)
                else:
                    self._reply(frame)
        except ProtocolError as error:
            self._complain(error)
            self.transport.close()

    def send(self, frame: Frame) -> None:
        if self.transport.get_write_buffer_size() > _MAX_UNREAD:
            self.transport.abort()  # it asks and never reads
        elif not self.transport.is_closing():
            self.transport.write(encode(frame))

    def _reply(self, request: Frame) -> None:
        try:
            answer = self._emulator.answer(request)
        except ProtocolError as error:
            self._complain(error)
            return
        if answer is not None:
            self.send(answer)

    def _complain(self, error: ProtocolError) -> None:
        self._emulator.refused += 1
        if not self._complained:
            self._complained = True
            log.warning("client %s: %s", self.transport.get_extra_info("peername"), error)


class Emulator:
    """A running emulator; a context manager."""

    def __init__(
        self,
        settings: EmulatorSettings,
        surface: SkinSurface | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Open the port and start to move and push.

        Args:
            settings: Where and which.
            surface: What the brush may touch; nothing by default.
            clock: Time of the body [s].

        Raises:
            ArmConnectionError: When the port cannot be opened.
        """
        arm = Arm(Kinematics(settings.variant), RM65_LIMITS, Brush(), settings.generation)
        controller = Controller(
            arm,
            np.radians(settings.joints_deg),
            surface or NoSurface(),
            clock,
            np.random.default_rng(settings.seed),
        )
        self._desk = Desk(controller, PushSettings(port=settings.udp_port))
        self._lock = threading.Lock()
        self._sender = PushSender()
        self.sessions: set[_Session] = set()
        self.refused = 0
        self.late = 0
        self._open = True
        self._loop = asyncio.new_event_loop()
        try:
            self._server = self._loop.run_until_complete(
                self._loop.create_server(lambda: _Session(self), settings.host, settings.port)
            )
        except (OSError, UnicodeError) as error:
            self._loop.close()
            raise ArmConnectionError(
                f"cannot listen on {settings.host}:{settings.port}: {error}; choose another host or port"
            ) from error
        self.port = int(self._server.sockets[0].getsockname()[1])
        self._threads = [
            threading.Thread(target=self._serve, name="emulator-tcp", daemon=True),
            threading.Thread(target=self._run, name="emulator-arm", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def answer(self, request: Frame) -> Frame | None:
        """Answer one request of a client."""
        with self._lock:
            return reply(self._desk, request)

    def truth(self) -> Truth:
        """How things really are, now."""
        with self._lock:
            controller = self._desk.controller
            return Truth(controller.T_base_head, controller.contact, controller.dynamics.joints)

    @property
    def pushed(self) -> int:
        """Datagrams sent so far."""
        return self._sender.sent

    def close(self) -> None:
        """Cut off all clients and end the threads."""
        if not self._open:
            return
        self._open = False
        self._loop.call_soon_threadsafe(self._shut)
        for thread in self._threads:
            thread.join(5.0)
        self._loop.close()
        self._sender.close()

    def __enter__(self) -> "Emulator":
        return self

    def __exit__(self, *exc: object) -> None:
        self.close()

    def _shut(self) -> None:
        self._server.close()
        for session in list(self.sessions):
            session.transport.abort()
        self._loop.call_soon(self._loop.stop)

    def _serve(self) -> None:
        raise_priority()
        self._loop.run_forever()

    def _run(self) -> None:
        """Step the arm on an absolute schedule, so that lateness does not add up."""
        raise_priority()
        due, count = time.monotonic(), 0
        while self._open:
            with self._lock:
                settled = self._desk.controller.step()
                push = self._desk.push
                data = (
                    datagram(self._desk.controller, push) if push.enable and count % push.cycle == 0 else b""
                )
            if data:
                self._sender.send(data, push)
            if settled and self._open:
                self._loop.call_soon_threadsafe(self._tell, settled)
            count += 1
            due += STEP
            wait = due - time.monotonic()
            if wait > 0:
                time.sleep(wait)
            elif wait < -0.1:  # the machine stood still: do not hurry after it
                due, self.late = time.monotonic(), self.late + 1

    def _tell(self, settled: list[Settled]) -> None:
        """Send one completion event per ended motion to every client."""
        for end in settled:
            for session in list(self.sessions):
                session.send(
                    {
                        "state": "current_trajectory_state",
                        "trajectory_state": end.reached,
                        "device": 0,
                        "trajectory_connect": 0,
                    }
                )


def run(
    settings: EmulatorSettings,
    surface: SkinSurface | None = None,
    clock: Callable[[], float] = time.monotonic,
) -> None:
    """Run an emulator until Ctrl-C."""
    with Emulator(settings, surface, clock) as emulator:
        log.info("RM65-%s emulator listens on %s:%d", settings.variant, settings.host, emulator.port)
        threading.Event().wait()
