"""The states of the arm with regard to the person, every way from one to another, and alarms.

An alarm is what one watchdog found: how the arm must react, and what can still be trusted.

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
    START = "just started"
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
    Transition(State.FREE, State.HOLD, "stopped, or touched for long"),
    Transition(State.FREE, State.FAULT, "error of the program"),
    Transition(State.APPROACH, State.CONTACT, "skin felt"),
    Transition(State.APPROACH, State.FREE, "at home"),
    Transition(State.APPROACH, State.HOLD, "nothing felt, paused or stopped, or touched for long"),
    Transition(State.APPROACH, State.RETRACTING, "too much force, idle too long, or asked"),
    Transition(State.APPROACH, State.FAULT, "watchdog"),
    Transition(State.CONTACT, State.RETRACTING, "too much force, idle too long, or asked"),
    Transition(State.CONTACT, State.HOLD, "paused or stopped"),
    Transition(State.CONTACT, State.FAULT, "watchdog"),
    Transition(State.RETRACTING, State.FREE, "left as asked"),
    Transition(State.RETRACTING, State.HOLD, "left because it had to, or stopped"),
    Transition(State.RETRACTING, State.FAULT, "hard limit passed, or watchdog"),
    Transition(State.HOLD, State.APPROACH, "asked off the skin and allowed, or resumed"),
    Transition(State.HOLD, State.CONTACT, "resumed"),
    Transition(State.HOLD, State.FREE, "allowed to go on, or just started at home"),
    Transition(State.HOLD, State.RETRACTING, "too much force, idle too long, or asked"),
    Transition(State.HOLD, State.FAULT, "watchdog, on the skin"),
    Transition(State.FAULT, State.HOLD, "cause gone and resumed"),
    Transition(
        State.FAULT, State.RETRACTING, "pressed, idle too long, or asked while the joints can be trusted"
    ),
)


class Reaction(IntEnum):
    """What the arm does about it, from the mildest to the gravest."""

    NONE = 0
    TELL = 1  # a warning in the diagnostics
    WAIT = 2  # brake and stand; go on by itself when everything has been steady for a while
    LEAVE = 3  # leave the skin along the outward normal
    FAULT = 4  # brake and stand until a person resumes


class Alarm(NamedTuple):
    """One watchdog's finding."""

    name: str
    reaction: Reaction
    message: str
    force: bool = True  # whether the force can be trusted all the same
    joints: bool = True  # whether the joints can, and the stream of commands

    @property
    def doubtful(self) -> bool:
        """Whether nothing may begin: not while something measured cannot be trusted, nor in a fault."""
        return self.reaction is Reaction.FAULT or not (self.force and self.joints)

    @property
    def astray(self) -> bool:
        """Whether the arm does not do what it is told: to go on from there would make it leap."""
        return self.reaction is Reaction.FAULT and not self.joints


QUIET = Alarm("", Reaction.NONE, "")
