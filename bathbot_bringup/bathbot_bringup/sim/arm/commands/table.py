"""The table of commands: a name of the protocol, and a function that answers it.

A function takes the desk and the request and gives the reply, or None where the protocol answers nothing.
It raises for a request that must be refused, and the table says how that is told.
"""

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from bathbot_scrub.arm.errors import ArmError, ProtocolError
from bathbot_scrub.rm65.controller.protocol import Frame

from bathbot_bringup.sim.arm.controller.controller import Controller
from bathbot_bringup.sim.arm.controller.push import PushSettings
from bathbot_bringup.sim.arm.trace import Trace


@dataclass(slots=True)
class Desk:
    """What a command may look at and change."""

    controller: Controller
    push: PushSettings = field(default_factory=PushSettings)
    trace: Trace = field(default_factory=Trace)
    aside: Callable[[], contextlib.AbstractContextManager[None]] = (
        contextlib.nullcontext
    )  # lets the arm go on
    peer: str = "127.0.0.1"  # address of the client that came last
    clock: Callable[[], float] = time.monotonic  # stamps the frames of the trace [s]
    begun: float = field(init=False)  # [s] by that clock
    calibration: dict[int, Any] = field(default_factory=dict)  # poses of a manual calibration, by number
    velocity_frame: Any = None  # of movev_canfd, once it was announced

    def __post_init__(self) -> None:
        """Begin now."""
        self.begun = self.clock()


Command = Callable[[Desk, Frame], Frame | None]


class Entry(NamedTuple):
    """One command."""

    function: Command
    refusal: str  # key that is false when it is refused; empty: nothing is said
    since: int  # generation of the controller


COMMANDS: dict[str, Entry] = {}


def command(name: str, refusal: str = "get_state", since: int = 3) -> Callable[[Command], Command]:
    """Enter a function under the protocol's name."""

    def enter(function: Command) -> Command:
        COMMANDS[name] = Entry(function, refusal, since)
        return function

    return enter


def reply(desk: Desk, request: Frame) -> Frame | None:
    """Answer one request; None where the protocol answers nothing.

    Raises:
        ProtocolError: When the request lacks a command name.
    """
    name = request.get("command")
    if not isinstance(name, str):
        raise ProtocolError(f"request without a command: {str(request)[:80]}")
    entry = COMMANDS.get(name)
    if entry is None or entry.since > desk.controller.arm.generation:
        return {"command": name[:60], "receive_state": False}  # what firmware says is not published
    try:
        return entry.function(desk, request)
    except (ProtocolError, ArmError):
        return {"command": name, entry.refusal: False} if entry.refusal else None


def state(name: str, **values: Any) -> Frame:
    """A reply that is named after a state."""
    return {"state": name, **values}


def answer(name: str, **values: Any) -> Frame:
    """A reply that is named after its command."""
    return {"command": name, **values}


def word(request: Frame, key: str, longest: int = 64) -> str:
    """Read a text at `key`.

    Raises:
        ProtocolError: When it is missing, none, or too long.
    """
    value = request.get(key)
    if not isinstance(value, str) or len(value) > longest:
        raise ProtocolError(f"{key} must be a text of at most {longest} characters, got {str(value)[:60]}")
    return value


def flag(request: Frame, key: str) -> bool:
    """Read true or false, or 1 or 0, at `key`.

    Raises:
        ProtocolError: When it is missing or neither.
    """
    value = request.get(key)
    if not isinstance(value, bool | int) or value not in (0, 1):
        raise ProtocolError(f"{key} must be true or false, got {str(value)[:60]}")
    return bool(value)


def choice(request: Frame, key: str, known: tuple[str, ...]) -> str:
    """Read one of several words at `key`.

    Raises:
        ProtocolError: When it is none of them.
    """
    value = request.get(key)
    if value not in known:
        raise ProtocolError(f"{key} must be one of {', '.join(known)}, got {str(value)[:60]}")
    return str(value)
