"""The state push: where to, how often, and what is in it."""

import ipaddress
from dataclasses import replace
from typing import Any

from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.rm65.controller.protocol import Frame, integer

from bathbot_bringup.sim.arm.commands.table import Desk, answer, command, flag, word
from bathbot_bringup.sim.arm.controller.push import BLOCKS


@command("get_realtime_push")
def _get(desk: Desk, request: Frame) -> Frame:
    push = desk.push
    return answer(
        "get_realtime_push",
        cycle=push.cycle,
        enable=push.enable,
        port=push.port,
        ip=push.ip or desk.peer,
        force_coordinate=push.force_coordinate,
        custom={block: block in push.blocks for block in BLOCKS},
    )


@command("set_realtime_push", "state")
def _set(desk: Desk, request: Frame) -> Frame:
    changes: dict[str, Any] = {}
    if "cycle" in request:
        changes["cycle"] = integer(request, "cycle", 1, 10_000)
    if "port" in request:
        changes["port"] = integer(request, "port", 1, 65535)
    if "force_coordinate" in request:
        changes["force_coordinate"] = integer(request, "force_coordinate", 0, 2)
    if "enable" in request:
        changes["enable"] = flag(request, "enable")
    if "ip" in request:
        changes["ip"] = _address(word(request, "ip"))
    if "custom" in request:
        changes["blocks"] = _blocks(request["custom"], desk.push.blocks)
    desk.push = replace(desk.push, **changes)
    return answer("set_realtime_push", state=True)


def _address(text: str) -> str:
    """Read an address; names are refused, for looking one up would hold up the arm."""
    try:
        return str(ipaddress.IPv4Address(text))
    except ValueError as error:
        raise ProtocolError(f"ip must be an address such as 192.168.1.10, got {text[:40]!r}") from error


def _blocks(custom: Any, before: frozenset[str]) -> frozenset[str]:
    """Switch optional parts on or off; those that are not named stay as they are."""
    if not isinstance(custom, dict):
        raise ProtocolError(f"custom must be an object, got {str(custom)[:60]}")
    on = {block for block in BLOCKS if block in custom and flag(custom, block)}
    return frozenset((before - set(custom)) | on)
