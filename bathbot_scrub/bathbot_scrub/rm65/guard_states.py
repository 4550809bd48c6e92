"""The states of the arm with regard to the person, and every way from one to another.

The diagram in `docs/safety.md` is compared with `TRANSITIONS` by a test.
"""

from enum import Enum, IntEnum
from typing import NamedTuple


class State(IntEnum):
    """States as in bathbot_msgs/ArmState."""

    FREE = 0
    APPROACH = 1
    CONTACT = 2
    RETRACTING = 3
    HOLD = 4
    FAULT = 5


class Action(Enum):
    """What the control loop must do at once."""

    GO_ON = "go on"
    STOP = "stop"
    RESUME = "resume"
    RETRACT = "retract"


class Cause(Enum):
    """Why the guard ended a motion."""

    NONE = "none"
    NO_CONTACT = "no contact"
    FORCE = "force"
    DATA = "data"
    IDLE = "idle"


class Transition(NamedTuple):
    """One way from a state to another."""

    before: State
    after: State
    because: str


TRANSITIONS = (
    Transition(State.FREE, State.APPROACH, "asked to approach or to go home"),
    Transition(State.FREE, State.RETRACTING, "asked, or followed by the person it left"),
    Transition(State.FREE, State.HOLD, "stopped"),
    Transition(State.FREE, State.FAULT, "error of the program"),
    Transition(State.APPROACH, State.CONTACT, "skin felt"),
    Transition(State.APPROACH, State.FREE, "at home"),
    Transition(State.APPROACH, State.HOLD, "nothing felt, paused or stopped"),
    Transition(State.APPROACH, State.RETRACTING, "too much force, or asked"),
    Transition(State.APPROACH, State.FAULT, "watchdog"),
    Transition(State.CONTACT, State.RETRACTING, "too much force, idle too long, or asked"),
    Transition(State.CONTACT, State.HOLD, "paused or stopped"),
    Transition(State.CONTACT, State.FAULT, "watchdog"),
    Transition(State.RETRACTING, State.FREE, "left as asked"),
    Transition(State.RETRACTING, State.HOLD, "left because it had to, or stopped"),
    Transition(State.RETRACTING, State.FAULT, "hard limit passed, or watchdog"),
    Transition(State.HOLD, State.APPROACH, "asked off the skin and allowed, or resumed"),
    Transition(State.HOLD, State.CONTACT, "resumed"),
    Transition(State.HOLD, State.FREE, "allowed to go on"),
    Transition(State.HOLD, State.RETRACTING, "too much force, idle too long, or asked"),
    Transition(State.HOLD, State.FAULT, "watchdog, on the skin"),
    Transition(State.FAULT, State.HOLD, "cause gone and resumed"),
    Transition(State.FAULT, State.RETRACTING, "pressed, or asked while the joints can be trusted"),
)
