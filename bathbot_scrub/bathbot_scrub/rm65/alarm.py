"""What a watchdog says. Pure."""

from enum import IntEnum
from typing import NamedTuple


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
        waits = self.reaction is Reaction.WAIT and not (self.force and self.joints)
        return waits or self.reaction is Reaction.FAULT

    @property
    def astray(self) -> bool:
        """Whether the arm does not do what it is told: to go on from there would make it leap."""
        return self.reaction is Reaction.FAULT and not self.joints


QUIET = Alarm("", Reaction.NONE, "")
