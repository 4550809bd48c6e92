"""What a motion of the arm is for."""

from enum import Enum

from bathbot_scrub.rm65.guard_states import State


class Kind(Enum):
    """What a motion is for."""

    TRANSIT = "to the stand-off"
    SEEK = "towards the skin"
    SCRUB = "along the path"
    LEAVE = "away from the skin"
    HOME = "home"
    SENT = "where a program sent it"
    STREAM = "after a stream of joints"


ARRIVALS = {  # motions whose end ends a state, and what is said then
    Kind.SEEK: "at the end of the search",
    Kind.LEAVE: "retracted",
    Kind.HOME: "at home",
    Kind.SENT: "where it was sent",
}

MORE_MAY_COME = {Kind.SCRUB: State.CONTACT, Kind.STREAM: State.APPROACH}  # at rest at what came so far
