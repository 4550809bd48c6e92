"""The controller's error codes in words, as its documents list them."""

from collections.abc import Iterable

SYSTEM = {
    0x1001: "joint communication",
    0x1002: "target over the limit",
    0x1003: "target unreachable or singular",
    0x1004: "real-time kernel communication",
    0x1005: "joint bus",
    0x1006: "planner",
    0x1007: "joint overspeed",
    0x1008: "tool board",
    0x1009: "overspeed",
    0x100A: "over-acceleration",
    0x100B: "brake",
    0x100C: "overspeed while dragged",
    0x100D: "collision",
    0x100E: "no such work frame",
    0x100F: "no such tool frame",
    0x1010: "joint disabled",
    0x1011: "arc",
    0x1012: "self-collision",
    0x1013: "fence",
    0x1014: "soft limit",
    0x2001: "gripper",
    0x2002: "hand",
    0x2003: "six-axis force sensor",
    0x2004: "one-axis force sensor",
    0x2005: "current",
    0x5003: "controller too hot",
    0x5005: "overcurrent",
    0x5006: "undercurrent",
    0x5007: "overvoltage",
    0x5008: "undervoltage",
    0x5009: "real-time kernel",
}
JOINT_BITS = {
    0x0001: "field-oriented control",
    0x0002: "overvoltage",
    0x0004: "undervoltage",
    0x0008: "too hot",
    0x0010: "start",
    0x0020: "encoder",
    0x0040: "overcurrent",
    0x0080: "software",
    0x0100: "temperature sensor",
    0x0200: "over the limit",
    0x0400: "bad id",
    0x0800: "following error",
    0x1000: "current detection",
    0x2000: "brake",
    0x4000: "position step warning",
    0x8000: "turn counter lost",
}
_FRAME_LOSS = 0xF000
_UNREADABLE = -1


def system_error(code: int) -> str:
    """One code of the controller in words."""
    if code == _UNREADABLE:
        return "an error code that cannot be read"
    return f"error 0x{code:04X}: {SYSTEM.get(code, 'not in the list of codes')}"


def joint_error(joint: int, code: int) -> str:
    """The error bits of one joint, 1 to 6, in words."""
    if code & _FRAME_LOSS == _FRAME_LOSS:
        words = ["frames lost"]
    else:
        words = [word for bit, word in JOINT_BITS.items() if code & bit]
    return f"joint {joint}, error 0x{code & 0xFFFF:04X}: {', '.join(words) or 'not in the list of bits'}"


def in_words(system: Iterable[int], joints: Iterable[int]) -> str:
    """All errors that are not zero, in one line; empty when none."""
    told = [system_error(code) for code in system if code]
    told += [joint_error(number + 1, code) for number, code in enumerate(joints) if code]
    return "; ".join(told)
