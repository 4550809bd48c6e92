"""One TCP client of the emulated controller, and what faults do to its connection."""

import asyncio
import logging
from collections.abc import Callable

from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.rm65.controller.protocol import Frame, FrameBuffer, encode

from bathbot_bringup.sim.faults.fault_schedule import FaultSchedule
from bathbot_bringup.sim.faults.lasting_fault import Place
from bathbot_bringup.sim.faults.session_faults import SessionTrouble, session_trouble

log = logging.getLogger(__name__)
_MOST = 200  # clients at a time
_MAX_UNREAD = 1 << 20  # [bytes] a client may leave unread, or wait to be read, before it is cut off


class Sessions(set["Session"]):
    """All clients that are connected. Only the thread of the event loop touches it."""

    def __init__(
        self,
        answer: Callable[[Frame], Frame | None],
        faults: FaultSchedule,
        meet: Callable[[str], None] = lambda address: None,
    ) -> None:
        """Begin without any.

        Args:
            answer: Gives the reply to a request, None where the protocol has none; raises ProtocolError.
            faults: What fails.
            meet: Called with the address of each new client.
        """
        super().__init__()
        self.answer, self._faults, self.meet = answer, faults, meet
        self.refused = 0  # frames, ever

    @property
    def trouble(self) -> SessionTrouble:
        """What is wrong with the connections just now."""
        return session_trouble(self._faults.at(Place.SESSIONS))

    def drop(self) -> None:
        """Cut off all."""
        for session in list(self):
            session.transport.abort()

    def take_held(self) -> None:
        """Read what came in while the controller stood still."""
        for session in list(self):
            session.data_received(b"")
            if session.transport.is_closing():
                self.discard(session)

    def tell(self, frames: list[Frame]) -> None:
        """Send frames to all."""
        for session in list(self):
            for frame in frames:
                session.send(frame)


class Session(asyncio.Protocol):
    """One client."""

    def __init__(self, sessions: Sessions) -> None:
        """Belong to `sessions` as long as the connection lasts."""
        self._sessions, self._buffer = sessions, FrameBuffer()
        self._held = b""
        self._complained = False
        self.transport: asyncio.Transport

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin."""
        self.transport = transport  # type: ignore[assignment]
        self._sessions.add(self)
        self._sessions.meet(str(transport.get_extra_info("peername")[0]))
        if self._sessions.trouble.cut_off or len(self._sessions) > _MOST:
            self.transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """End; what has come is read all the same when a controller that stands still goes on."""
        if not (self._held and self._sessions.trouble.waiting):
            self._sessions.discard(self)

    def data_received(self, data: bytes) -> None:
        """Answer each frame; a bad one is refused, and told once."""
        trouble = self._sessions.trouble
        if trouble.deaf:
            return
        self._held += data
        if trouble.waiting:
            if len(self._held) > _MAX_UNREAD:
                self.transport.abort()
            return
        data, self._held = self._held, b""
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
        """Send a frame, late if replies are slow; cut off who never reads."""
        trouble = self._sessions.trouble
        if trouble.deaf:
            return
        if trouble.delay:
            asyncio.get_running_loop().call_later(trouble.delay, self._write, frame)
        else:
            self._write(frame)

    def _write(self, frame: Frame) -> None:
        if self.transport.is_closing():
            return
        if self.transport.get_write_buffer_size() > _MAX_UNREAD:
            self.transport.abort()  # it asks and never reads
        else:
            self.transport.write(encode(frame))

    def _reply(self, request: Frame) -> None:
        try:
            answer = self._sessions.answer(request)
        except ProtocolError as error:
            self._complain(error)
            return
        if answer is not None:
            self.send(answer)

    def _complain(self, error: ProtocolError) -> None:
        self._sessions.refused += 1
        if not self._complained:
            self._complained = True
            log.warning("client %s: %s", self.transport.get_extra_info("peername"), error)
