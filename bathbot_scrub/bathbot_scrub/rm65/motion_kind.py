"""What a motion of the arm is for."""

from enum import Enum


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
