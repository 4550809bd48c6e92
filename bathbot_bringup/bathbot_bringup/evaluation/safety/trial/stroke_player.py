"""Plays the planner: a stroke to and fro without end, in pieces, some of them ahead of the arm. Pure."""

from typing import NamedTuple

import numpy as np
from bathbot_scrub.segment.segment import Segment
from numpy.typing import NDArray

Array = NDArray[np.float64]
AHEAD = 3  # segments with the arm, the one under the head included, as scrub_planner keeps them
SPACING = 0.002  # [m] between poses
PIECE = 10  # poses in a segment


class Progress(NamedTuple):
    """How far the arm says it has come."""

    path_id: int
    segment_index: int
    path_done: bool


class LastPose(NamedTuple):
    """Where the path ends that the driver was given."""

    stamp: float  # [s] when it was heard
    position: Array  # [m], shape (3,)
    path_id: int


class StrokePlayer:
    """Gives the segment that is due, one at a time."""

    def __init__(self, path_id: int, region: str, stroke: Array, speed: float, pieces: int = 0) -> None:
        """Play a closed stroke.

        Args:
            path_id: Of the path.
            region: Whose limits hold.
            stroke: Head poses, (N, 4, 4), the last beside the first.
            speed: Wanted [m/s].
            pieces: After which the path ends; 0: never.
        """
        self.path_id, self.sent = path_id, 0
        self._region, self._stroke, self._speed, self._pieces = region, stroke, speed, pieces

    def is_due(self, progress: Progress | None) -> bool:
        """Whether the arm has too few segments ahead of it."""
        if self._pieces and self.sent >= self._pieces:
            return False
        reached = progress.segment_index if progress is not None and progress.path_id == self.path_id else 0
        return self.sent - reached < AHEAD

    def due(self, progress: Progress | None) -> Segment | None:
        """The next segment when it is due, else None."""
        return self.take() if self.is_due(progress) else None

    def take(self) -> Segment:
        """The next segment, due or not."""
        order = np.arange(self.sent * PIECE, (self.sent + 1) * PIECE) % len(self._stroke)
        index, self.sent = self.sent, self.sent + 1
        last = self.sent == self._pieces
        return Segment(self.path_id, index, last, self._region, self._stroke[order], self._speed, SPACING)


def spoilt(segment: Segment) -> Segment:
    """The same segment with poses that are not finite."""
    poses = segment.T_base_heads.copy()
    poses[:, :3, 3] = np.nan
    return segment._replace(T_base_heads=poses)
