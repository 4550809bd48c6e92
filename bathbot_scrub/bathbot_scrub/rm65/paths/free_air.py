"""Where to go when something is met on the way through free air: along it, back or on, as the push leads."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.rm65.paths.joint_path import JointPath, slowed

Array = NDArray[np.float64]
_FAR = 0.8  # [rad] back, or on, after something was met
_SLOWEST, FASTEST = 0.3, 2.0  # [rad/s] of the joint that turns most
_DECELERATION = 4.0  # [rad/s^2] towards slower parts and the end, where haste is over
_ARRIVAL = 0.1  # [rad/s] from which any brake is gentle
_NEAR = 0.05  # [rad] off a way within which an arm counts as on it
_AHEAD = 0.01  # [rad] by which directions are told
_GIVES_IN = 0.5  # cosine of way and push above which a way gives in to it


class OnWay(NamedTuple):
    """A way through free air, and where on it the arm is."""

    path: JointPath
    length: float  # [rad]

    def holds(self, joints: Array) -> bool:
        """Whether an arm at joints [rad], shape (J,), is on it."""
        return bool(np.abs(self.path.at(self.length) - joints).max() < _NEAR)

    def back(self, arm: Arm, speed: float) -> "Along":
        """The way it came, known to be free, the head at `speed` [m/s]."""
        return Along(self, -1, _paced(self.path.back_from(self.length, _FAR), arm, speed))

    def yielding(self, arm: Arm, push: Array, speed: float, least: float = 0.0) -> "Along | None":
        """The part of the way, back or on, that takes the head where a push on it leads; None: neither does.

        Args:
            arm: Whose way it is.
            push: Force on the head, base frame [N], shape (3,).
            speed: Of the head [m/s].
            least: How far a part must take it there [m].
        """
        places = [self.length, *(self.length + sign * _AHEAD for sign in (-1, 1))]
        ends = (max(self.length - _FAR, 0.0), min(self.length + _FAR, self.path.end))
        heads = arm.head(np.stack([self.path.at(s) for s in (*places, *ends)]))[:, :3, 3]
        heads = heads - heads[0]
        for sign, first, last in ((-1, heads[1], heads[3]), (1, heads[2], heads[4])):
            if _cosine(first, push) >= _GIVES_IN and last @ push >= least * np.linalg.norm(push):
                part = self.path.back_from if sign < 0 else self.path.on_from
                return Along(self, sign, _paced(part(self.length, _FAR), arm, speed))
        return None


class Along(NamedTuple):
    """A part of a way, back (-1) or on (1) from where the arm was."""

    begin: OnWay
    sign: int
    path: JointPath

    def at(self, length: float) -> OnWay:
        """Where on the whole way the arm is at a length of this part [rad]."""
        return OnWay(self.begin.path, self.begin.length + self.sign * length)


def _paced(path: JointPath, arm: Arm, speed: float) -> JointPath:
    """A path with the head at a speed [m/s], where the joints then turn neither too slowly nor too fast."""
    moved = np.linalg.norm(np.diff(arm.head(path.joints)[:, :3, 3], axis=0), axis=-1) / np.diff(path.lengths)
    turned = np.clip(speed / np.maximum(moved, 1e-9), _SLOWEST, FASTEST)
    return slowed(replace(path, speed_limit=np.append(turned, turned[-1])), _DECELERATION, _ARRIVAL)


def _cosine(way: Array, push: Array) -> float:
    """Of the angle between two vectors, shape (3,); -1 where one has no length."""
    lengths = float(np.linalg.norm(way) * np.linalg.norm(push))
    return float(way @ push) / lengths if lengths > 1e-9 else -1.0
