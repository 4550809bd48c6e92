"""One piece of a scrub path, as the planner lays it and the driver follows it, or refuses it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

MOST_POSES = 500  # in one segment


class Segment(NamedTuple):
    """The fields of bathbot_msgs/ScrubSegment.

    Attributes:
        path_id: Of the path; a segment of another begins a new path.
        index: 0, 1, 2, ... within one path.
        last: Whether it is the final one.
        region: Whose skin is scrubbed; chooses the limits of force.
        T_base_heads: Poses of the head, shape (N, 4, 4), evenly spaced, N at most MOST_POSES.
        speed: Wanted along the path [m/s].
        spacing: Of the poses along the path [m]; 0: not told.
        stamp: Time of the surface it was planned on [s]; 0: on none.
    """

    path_id: int
    index: int
    last: bool
    region: str
    T_base_heads: NDArray[np.float64]
    speed: float
    spacing: float = 0.0
    stamp: float = 0.0


def refusal(path_id: int, index: int, why: str) -> str:
    """What the driver says of itself, as `reason`, once it has refused a segment."""
    return f"{_refused(path_id)} {index} was refused: {why}"


def is_refusal(reason: str, path_id: int) -> bool:
    """Whether a driver's `reason` says that it has refused a segment of a path."""
    return reason.startswith(_refused(path_id))


def _refused(path_id: int) -> str:
    return f"path {path_id}: segment"
