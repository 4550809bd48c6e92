"""How fast the arm may go along a path where somebody may be by the time it comes there.

The camera tells where the body was when the path was planned. Since then somebody may have leaned forward, so
all that is within a lean of the last cloud counts as near; where there is no cloud, everything does. Near
people no part of the arm moves faster than a body bears to be hit, and the head comes no faster towards the
body - in any direction but back, where that is not known - than its bristles bear to meet someone who leans.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.clearance import BodyClearance, capsule_ends
from bathbot_scrub.arm.collision_speed import collision_speed, meeting_speed

Array = NDArray[np.float64]
LEAN = 0.2  # [m] that somebody may have leaned since the last cloud
_CELL = 0.02  # [m] within which one point of a body stands for all
_BACKWARDS = -0.5  # cosine of the head's way and its axis below which it draws back
_BODY = 0.1  # [m/s] of a person who leans towards the head
_FELT = 0.003  # [m] that the bristles bend until a touch in free air is noticed
_DELAY = 0.03  # [s] from there to joints that slow down
_DECELERATION = 5.0  # [m/s^2] of the head while all joints turn round


class SpeedsNearPeople(NamedTuple):
    """What no part of the arm exceeds near people [m/s]."""

    links: float
    meeting: float  # of the head towards the body


def speeds_near_people(arm: Arm) -> SpeedsNearPeople:
    """Those of an arm; who will be met is not known, so the gentlest class counts."""
    links = collision_speed("", arm.moving_mass, arm.tool.mass)
    meeting = meeting_speed(arm.tool.give - _FELT, _DELAY, _DECELERATION, _BODY)
    return SpeedsNearPeople(links, min(meeting, links))


class SpeedNearPeople:
    """Caps the speed along joint paths of one arm."""

    def __init__(self, arm: Arm, clearance: BodyClearance, margin: float) -> None:
        """Cap it within a lean and `margin` [m] of a body; `clearance` is that of the arm."""
        self._arm, self._clearance, self._near = arm, clearance, LEAN + margin
        self.speeds = speeds_near_people(arm)
        self._head = np.array([capsule.link == arm.tool.frame for capsule in clearance.capsules])

    def caps(self, lengths: Array, joints: Array, points: Array | None) -> Array:
        """Largest ds/dt at each sample of a path, shape (N,); inf where nobody can be near.

        Args:
            lengths: s of the samples, shape (N,), strictly rising.
            joints: [rad], shape (N, J).
            points: On the body, shape (M, 3), base frame [m]; None: it may be anywhere.
        """
        ends = capsule_ends(self._arm, self._clearance.capsules, joints)
        steps = np.diff(lengths)[:, None]
        # (N - 1, C) of each capsule, m for each unit of s
        pace = np.linalg.norm(np.diff(ends, axis=0), axis=-1).max(-1) / steps
        limit = self.speeds.links / np.maximum(pace, 1e-9)
        if points is None:
            beside, closing = np.ones(pace.shape, bool), pace[:, self._head] * self._faces(joints)
        else:
            apart = self._clearance.each(ends, thinned(points), self._near)
            beside = np.minimum(apart[1:], apart[:-1]) < self._near
            closing = -np.diff(apart[:, self._head], axis=0) / steps
        meets = self.speeds.meeting / np.maximum(closing, 1e-9)
        limit[:, self._head] = np.minimum(limit[:, self._head], meets)
        allowed = np.where(beside, limit, np.inf).min(axis=1)
        return np.minimum(np.append(allowed, allowed[-1]), np.insert(allowed, 0, allowed[0]))

    def _faces(self, joints: Array) -> Array:
        """Between which samples the head does not draw back, shape (N - 1, 1)."""
        tips = self._arm.head(joints)
        steps = np.diff(tips[:, :3, 3], axis=0)
        forwards = (steps * tips[:-1, :3, 2]).sum(-1)
        return (forwards > _BACKWARDS * np.linalg.norm(steps, axis=-1))[:, None]


def thinned(points: Array) -> Array:
    """One point of each cell, shape (K, 3) of (M, 3) [m]."""
    _, kept = np.unique(np.floor(points / _CELL).astype(np.int64), axis=0, return_index=True)
    return np.ascontiguousarray(points[kept])
