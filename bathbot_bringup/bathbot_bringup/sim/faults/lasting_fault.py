"""A fault while it lasts, as it acts in one place of the emulated controller."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any


class Place(Enum):
    """Where a fault acts; beside it, the file with what it may do there."""

    FORCE_SENSOR = "force_faults"
    PUSH = "push_faults"
    SESSIONS = "session_faults"
    JOINTS = "joint_faults"
    BODY = "pushed_surface"


@dataclass(frozen=True, slots=True)
class LastingFault:
    """A fault that lasts; a place calls it in every step with what it has to offer.

    Attributes:
        act: What it does there: takes this fault, then what the place gives; see the row of its kind.
        value: How strong it is.
        memory: What it remembers in this place since it began; empty at first.
    """

    act: Callable[..., Any]
    value: float
    memory: dict[str, Any]

    def __call__(self, *inputs: Any) -> Any:
        """Act once."""
        return self.act(self, *inputs)
