"""How near the links come to what the camera sees, outside the patch that is washed.

A joint path is thinned out to samples (`swept`) between which no part of the arm strays farther than is
known; at each of them the distance of the links' capsules from the points of the body is taken.
"""

from typing import NamedTuple

import numpy as np
from bathbot_localize.arm.arm_shape import ArmCapsule
from numpy.typing import NDArray

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.clearance_kernel import beside, fill_clearances, within

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_STRIDE = 0.005  # [m] that no end of a capsule moves farther between two samples, within one given step
PATCH_RADIUS = 0.06  # [m] about the place that is washed within which the head may touch the body


class SweptArm(NamedTuple):
    """Where the capsules are at the samples, and how far they stray between these."""

    joints: Array  # (N, J) [rad] of the samples
    ends: Array  # (N, C, 2, 3) of the capsules' axes, base frame [m]
    stray: Array  # (N,) [m] that any part of the arm is off the nearest sample, half-way to the next
    places: NDArray[np.int64]  # (N,) of the samples in the dense path


class Nearest(NamedTuple):
    """At each of N samples: the distance of arm and body, and between what."""

    clearances: Array  # (N,) [m] of surfaces, negative inside; not told apart beyond what was asked for
    links: NDArray[np.int64]  # (N,) index of the capsule; -1: none so near
    points: NDArray[np.int64]  # (N,) index of the point


class BodyClearance:
    """The links that move, of one arm."""

    def __init__(self, arm: Arm) -> None:
        """Take the capsules of the arm; compiles, or loads, what it needs."""
        self._arm = arm
        self.capsules = arm.shape.moving
        self._radii = np.array([capsule.radius for capsule in self.capsules])
        self._touches = np.array([capsule.link == arm.tool.frame for capsule in self.capsules])
        self.free(np.zeros((1, len(arm.joint_names))), np.ones((1, 3)), 0.0)
        self.beside(np.zeros((len(self.capsules), 2, 3)), np.ones((1, 3)), np.zeros((1, 3)), 0.0)

    def swept(self, joints: Array) -> SweptArm:
        """A closely spaced joint path, shape (N, J) [rad], thinned out."""
        return swept(self._arm, self.capsules, joints)

    def free(self, joints: Array, points: Array, margin: float) -> Mask:
        """Which postures, shape (N, J) [rad], keep a margin [m] to points, (M, 3); heads may touch at any."""
        ends = capsule_ends(self._arm, self.capsules, joints)
        patch = self._arm.head(joints)[:, :3, 3]
        return self.nearest(ends, points, patch, margin).clearances >= margin

    def beside(self, ends: Array, points: Array, patch: Array, margin: float) -> Mask:
        """Which points, shape (M, 3), are within a margin [m] of the arm at one sample, ends (C, 2, 3)."""
        spared = within(points, patch, PATCH_RADIUS)
        return beside(ends, self._radii, self._touches, points, spared, margin)

    def nearest(self, ends: Array, points: Array, patch: Array, interest: float) -> Nearest:
        """What of the arm is nearest to the body, at each sample.

        Args:
            ends: Of the capsules' axes, shape (N, C, 2, 3), base frame [m].
            points: On the body, shape (M, 3) [m].
            patch: Places, shape (K, 3) [m], about which the scrub head may touch the body.
            interest: Distances beyond are not told apart [m].
        """
        reach = self._radii.max() + interest
        low, high = ends.min(axis=(0, 1, 2)) - reach, ends.max(axis=(0, 1, 2)) + reach
        some = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
        found = (np.empty(len(ends)), *np.empty((2, len(ends)), int))
        spared = within(points[some], patch, PATCH_RADIUS)
        fill_clearances(ends, self._radii, self._touches, points[some], spared, interest, *found)
        return Nearest(found[0], found[1], some[found[2]] if len(some) else found[2])

    def each(self, ends: Array, points: Array, interest: float) -> Array:
        """Distance of each capsule from the nearest of some points, shape (N, C) [m]; as for `nearest`.

        Nothing may be touched. Distances beyond `interest` [m] are not told apart.
        """
        found = np.full(ends.shape[:2], interest)
        link, point = np.empty((2, len(ends)), int)
        none, touches = np.zeros(len(points), np.bool_), np.zeros(1, np.bool_)
        for part in range(ends.shape[1]):
            one = np.ascontiguousarray(ends[:, part : part + 1])
            radius, apart = self._radii[part : part + 1], found[:, part]
            fill_clearances(one, radius, touches, points, none, interest, apart, link, point)
        return found


def swept(arm: Arm, capsules: tuple[ArmCapsule, ...], joints: Array) -> SweptArm:
    """Thin out a dense joint path.

    A point of a capsule lies between the ends of its axis, so it moves no farther than they do.

    Args:
        arm: Whose capsules they are.
        capsules: In the frames of the links.
        joints: Closely spaced, shape (M, J) [rad]; first and last are kept.
    """
    ends = capsule_ends(arm, capsules, joints)
    steps = np.linalg.norm(np.diff(ends, axis=0), axis=-1).max(axis=(1, 2))
    way = np.concatenate([[0.0], np.cumsum(steps)])
    kept = np.unique(
        np.concatenate([[0], np.flatnonzero(np.diff(np.floor(way / _STRIDE))) + 1, [len(way) - 1]])
    )
    gaps = np.diff(way[kept])
    stray = 0.5 * np.maximum(np.append(gaps, 0.0), np.insert(gaps, 0, 0.0))
    return SweptArm(joints[kept], ends[kept], stray, kept)


def capsule_ends(arm: Arm, capsules: tuple[ArmCapsule, ...], joints: Array) -> Array:
    """Ends of the capsules' axes, shape (N, C, 2, 3), base frame [m], for joints (N, J) [rad]."""
    frames = arm.link_frames(joints)
    frames = np.concatenate([frames, frames[:, -1:] @ arm.tool.T_flange_head], axis=1)
    places = [(*arm.link_names, arm.tool.frame).index(capsule.link) for capsule in capsules]
    local = np.array([(c.start, c.end) for c in capsules])
    frames = frames[:, places]
    ends = np.einsum("ncij,cej->ncei", frames[..., :3, :3], local) + frames[:, :, None, :3, 3]
    return np.ascontiguousarray(ends)
