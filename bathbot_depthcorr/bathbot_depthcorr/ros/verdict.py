"""How well a stage goes, in the terms of /diagnostics."""

from enum import Enum
from typing import NamedTuple


class Level(Enum):
    """How well it goes; values as in diagnostic_msgs/DiagnosticStatus."""

    OK = b"\x00"
    WARN = b"\x01"
    ERROR = b"\x02"


class Verdict(NamedTuple):
    """Level and one line of reason."""

    level: Level
    message: str
