"""Where to go when something is met on the way through free air: along it, back or on, as the push leads."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.rm65.paths.joint_path import JointPath

Array = NDArray[np.float64]
_FAR = 0.8  # [rad] back, or on, after something was met
_AHEAD = 0.05  # [rad] by which directions are told
_GIVES_IN = 0.5  # cosine of way and push above which a way gives in to it


class OnWay(NamedTuple):
    """A way through free air, and where on it the arm is."""

    path: JointPath
    length: float  # [rad]

    def back(self) -> "Along":
        """The way it came; known to be free."""
        return Along(self, -1, self.path.back_from(self.length, _FAR))

    def yielding(self, arm: Arm, push: Array) -> "Along | None":
        """The part of the way, back or on, that takes the head where a push on it leads; None: neither does.

        Args:
            arm: Whose way it is.
            push: Force on the head, base frame [N], shape (3,).
        """
        lengths = (self.length, max(self.length - _AHEAD, 0.0), min(self.length + _AHEAD, self.path.end))
        here, before, behind = arm.head(np.stack([self.path.at(length) for length in lengths]))[:, :3, 3]
        if _cosine(before - here, push) >= _GIVES_IN:
            return self.back()
        if _cosine(behind - here, push) >= _GIVES_IN:
            return Along(self, 1, self.path.on_from(self.length, _FAR))
        return None


class Along(NamedTuple):
    """A part of a way, back (-1) or on (1) from where the arm was."""

    begin: OnWay
    sign: int
    path: JointPath

    def at(self, length: float) -> OnWay:
        """Where on the whole way the arm is at a length of this part [rad]."""
        return OnWay(self.begin.path, self.begin.length + self.sign * length)


def _cosine(way: Array, push: Array) -> float:
    """Of the angle between two vectors, shape (3,); -1 where one has no length."""
    lengths = float(np.linalg.norm(way) * np.linalg.norm(push))
    return float(way @ push) / lengths if lengths > 1e-9 else -1.0
