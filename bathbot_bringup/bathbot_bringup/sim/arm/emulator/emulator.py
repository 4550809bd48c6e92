"""The emulated controller on the wire: a TCP server of the vendor's protocol and a 200 Hz UDP push.

Two threads: an asyncio loop answers the clients, a clocked thread moves the arm and pushes its state.
One lock stands around the controller.
"""

import asyncio
import ipaddress
import logging
import math
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
from bathbot_scrub.arm.errors import ArmConnectionError
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.controller.protocol import Frame
from bathbot_scrub.rm65.timing.priority import raise_priority
from numpy.typing import NDArray

import bathbot_bringup.sim.arm.commands  # noqa: F401 - fills the table
from bathbot_bringup.sim.arm.commands.table import Desk, reply
from bathbot_bringup.sim.arm.controller.arm_setup import Arm
from bathbot_bringup.sim.arm.controller.controller import STEP, Controller
from bathbot_bringup.sim.arm.controller.push import PushSender, PushSettings, datagram
from bathbot_bringup.sim.arm.emulator.session import Session, Sessions
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_bringup.sim.arm.emulator.surface import NoSurface
from bathbot_bringup.sim.arm.trace import Trace
from bathbot_bringup.sim.brush import Brush, Contact, SkinSurface
from bathbot_bringup.sim.faults.fault_schedule import BEGIN, FaultEvent, FaultSchedule
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_bringup.sim.faults.kinds import KINDS, NONE

Array = NDArray[np.float64]
log = logging.getLogger(__name__)
_LATE = 2.5 * STEP  # [s] behind its schedule at which a step pushes no more
_GIVEN_UP = 0.5  # [s] behind at which the schedule begins anew


class Truth(NamedTuple):
    """What only a simulator knows."""

    T_base_head: Array  # (4, 4)
    contact: Contact
    joints: Array  # [rad], shape (6,)


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
        self.faults, self.trace = FaultSchedule(), Trace()
        arm = Arm(RM65(settings.variant), RM65_LIMITS, Brush(), settings.generation)
        controller = Controller(
            arm,
            np.radians(settings.joints_deg),
            surface or NoSurface(),
            clock,
            np.random.default_rng(settings.seed),
            self.faults,
        )
        self._desk = Desk(controller, PushSettings(port=settings.udp_port), self.trace, self._let_go)
        self._lock = threading.RLock()
        self.sessions = Sessions(self.answer, self.faults, self._meet)
        self.late = 0  # steps that did not come in time, ever
        self._open = True
        self._loop = asyncio.new_event_loop()
        self._server = self._listen(settings.host, settings.port)
        self.port = int(self._server.sockets[0].getsockname()[1])
        self._sender = PushSender(self.faults)
        self._threads = [
            threading.Thread(target=self._serve, name="emulator-tcp", daemon=True),
            threading.Thread(target=self._run, name="emulator-arm", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def _listen(self, host: str, port: int) -> asyncio.Server:
        try:
            opened = self._loop.create_server(lambda: Session(self.sessions), host, port)
            server = self._loop.run_until_complete(opened)
        except (OSError, UnicodeError) as error:
            self._loop.close()
            raise ArmConnectionError(
                f"cannot listen on {host}:{port}: {error}; choose another host or port"
            ) from error
        if not is_loopback(host):
            log.warning("the emulator listens on %s: whoever reaches it may move its arm", host)
        return server

    def answer(self, request: Frame) -> Frame | None:
        """Answer one request of a client."""
        with self._lock:
            return reply(self._desk, request)

    @contextmanager
    def _let_go(self) -> Iterator[None]:
        """Let the arm go on while a command that holds the lock plans."""
        self._lock.release()
        try:
            yield
        finally:
            self._lock.acquire()

    def _meet(self, address: str) -> None:
        self._desk.peer = address

    def truth(self) -> Truth:
        """How things really are, now."""
        with self._lock:
            controller = self._desk.controller
            return Truth(controller.T_base_head, controller.contact, controller.dynamics.joints)

    def order(self, fault: Fault) -> None:
        """Let something fail, from any thread; `fault.after` counts from now."""
        self.faults.order(fault, time.monotonic())

    @property
    def refused(self) -> int:
        """Frames that were refused so far."""
        return self.sessions.refused

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
        self.sessions.drop()
        self._loop.call_soon(self._loop.stop)

    def _serve(self) -> None:
        raise_priority()
        self._loop.run_forever()

    def _run(self) -> None:
        """Step the arm on an absolute schedule, so that lateness does not add up.

        Steps that were missed are made up for, so that the arm moves as far as it would have; but they push
        nothing: whoever listens must not get a burst of states that are old.
        """
        raise_priority()
        due, count = time.monotonic(), 0
        while self._open:
            now = time.monotonic()
            behind = now - due
            if behind > _GIVEN_UP:
                self.late += int(behind / STEP)
                due, behind = now, 0.0
            self.late += behind > _LATE
            self._step(now, count, behind <= _LATE)
            count += 1
            due += STEP
            time.sleep(max(due - time.monotonic(), 0.0))

    def _step(self, now: float, count: int, in_time: bool) -> None:
        events = self.faults.update(now)
        with self._lock:
            for event in events:
                self._begin_or_end(event)
            controller, push = self._desk.controller, self._desk.push
            settled = controller.step()
            due = in_time and push.enable and count % push.cycle == 0 and not controller.frozen
            state = datagram(controller, push) if due else None
        self.trace.events(events)
        pushed = self._sender.send(state, (push.ip or self._desk.peer, push.port), now) if state else math.nan
        self.trace.step(trace_row(now, controller, pushed))
        if settled and self._open:
            frames = [end.frame for end in settled if end.frame is not None]
            self._loop.call_soon_threadsafe(self.sessions.tell, frames)

    def _begin_or_end(self, event: FaultEvent) -> None:
        """Do what happens once, when a fault begins or ends."""
        log.warning("all faults have ended" if event.kind == NONE else f"fault {event.kind} {event.phase}s")
        kind = KINDS[event.kind]
        (kind.at_begin if event.phase == BEGIN else kind.at_end)(self)

    def cut_power(self) -> None:
        """Let the joints lose power."""
        self._desk.controller.cut_power()

    def freeze(self) -> None:
        """Let the controller's program stand still; the joints go on to the last target."""
        self._desk.controller.frozen = True

    def thaw(self) -> None:
        """Let it go on, with what came in meanwhile."""
        self._loop.call_soon_threadsafe(self._take_held)

    def _take_held(self) -> None:
        """Read what waited, then go on; within one step, as a program does that is not written in Python."""
        with self._lock:
            self.sessions.take_held()
            self._desk.controller.frozen = False

    def drop_clients(self) -> None:
        """Cut off all clients."""
        self._loop.call_soon_threadsafe(self.sessions.drop)

    def put_body_back(self) -> None:
        """Put the body where it was."""
        self._desk.controller.skin.surface.put_back()


def is_loopback(host: str) -> bool:
    """Whether an address is heard by this machine only; of a name that is known of localhost alone."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def trace_row(stamp: float, controller: Controller, pushed: float) -> list[float]:
    """A step for the trace: the truth after it, and the resultant as pushed [N]."""
    dynamics, T, contact = controller.dynamics, controller.T_base_head, controller.contact
    return [
        stamp, *dynamics.positions, *dynamics.speeds, *T[:3, 3], *T[:3, 2], *contact.force,
        contact.compression, contact.indentation, pushed,
    ]  # fmt: skip
