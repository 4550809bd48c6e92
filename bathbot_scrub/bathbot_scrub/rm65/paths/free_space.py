"""Joints to pass on paths through free air between a posture next to the person and one that is not.

What the camera does not see of a body is not known, so no link may pass the plane through the end nearest to
the person, whatever `Surroundings` may say of the points that are known.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, permutations

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.branches import wrap
from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.joint_limits import JointLimits
from bathbot_scrub.arm.tool_path import densify, retreated, solve_path
from bathbot_scrub.rm65.paths.joint_path import JointPath

Array = NDArray[np.float64]
_STEP = 0.01  # [m] between samples over the skin
_FARTHEST = 0.3  # [m] from the stand-off; from farther away the skin between is not known
_SAME = 0.05  # [rad] within which two postures are one
_PLANE_SLACK = 0.02  # [m] that any link may pass the plane through the end next to the person
_DETOUR = 1.6  # longest way of the head over the straight distance
_DETOUR_FREE = 0.15  # [m] that are no detour
_BACKS = (0.16, 0.12, 0.08, 0.04, 0.0)  # [m] straight back from the person before the joints fold
_BEHIND = 0.02  # [m] beside the straight way back within which a head is on it
_FACING = 0.99  # cosine between axes of heads that face the same skin
_GROUPS = (slice(0, 1), slice(1, 3), slice(3, 6))  # joints of base, arm and wrist


@dataclass(frozen=True, slots=True)
class FreeSpace:
    """Finds the way through it for one arm, as joints to pass."""

    arm: Arm
    home: Array  # folded posture [rad], shape (6,): the wrist may turn freely there
    limits: JointLimits

    def waypoints(self, near: Array, far: Array, side: Array) -> Iterator[list[Array]]:
        """Joints to pass from `near` the person to `far`, the last left out: one list for each clear way.

        The most direct comes first; others go straight back from the person before the joints fold.

        Raises:
            UnreachableError: When there is no way at all, with what is in the way of the most direct.
        """
        first, found = None, False
        T = self.arm.head(near)
        for back in self._backs(T, self.arm.head(far)):
            try:
                line = [near]
                if back:
                    poses = densify([T, retreated(T, back)], 0.01)[1]
                    line = list(solve_path(self.arm, poses, near, self.limits))
                for folding in self._foldings(line[-1], far, side):
                    found = True
                    yield line + folding
            except UnreachableError as error:
                first = first or error
        if not found:
            raise first or UnreachableError("no way")

    def over_the_skin(self, start: Array, came: JointPath) -> Iterator[list[Array]]:
        """Joints to pass after `start` on the way home that the arm came on, home the last.

        Args:
            start: Joints now, shape (6,).
            came: From home to the stand-off.

        Raises:
            UnreachableError: The arm did not come from home, or its stand-off is far off or on another
                branch.
        """
        self._check_came(came)
        now, standoff = self.arm.head(start), self.arm.head(came.joints[-1])
        away = now[:3, 3] - standoff[:3, 3]
        if np.linalg.norm(away) > _FARTHEST:
            raise UnreachableError(
                f"the stand-off is {np.linalg.norm(away):.2f} m away, more than {_FARTHEST} m"
            )
        over = retreated(standoff, max(float(-away @ standoff[:3, 2]), 0.0))
        _, dense = densify(np.stack([now, over, standoff]), _STEP)
        across = solve_path(self.arm, dense, start, self.limits)
        wound = across[-1] - came.joints[-1]
        if np.abs(wrap(wound)).max() > _SAME or np.abs(wound[:5]).max() > _SAME:
            raise UnreachableError("the arm stands on another branch than it came on")
        left = came.lengths / max(came.end, 1e-9)
        back = came.joints + left[:, None] * wound
        way = [*across[1:], *back[-2::-1], self.home]
        if not self.limits.contain(way).all():
            raise UnreachableError("on the way back a joint would pass its limit")
        yield way

    def straight_back(self, start: Array, came: JointPath, side: Array) -> Iterator[list[Array]]:
        """The same, but to the stand-off straight in joint space, which unwinds what the skin wound up.

        Args:
            start: Joints now, shape (6,).
            came: From home to the stand-off.
            side: Head pose whose plane across z no link shall pass, (4, 4).

        Raises:
            UnreachableError: The arm did not come from home, or the way to the stand-off is not clear.
        """
        self._check_came(came)
        if obstacle := self._obstacle(start, came.joints[-1], side):
            raise UnreachableError(obstacle)
        yield [*came.joints[::-1], self.home]

    def _check_came(self, came: JointPath) -> None:
        if np.abs(came.joints[0] - self.home).max() > _SAME:
            raise UnreachableError("the arm did not come from home")

    def _backs(self, T_near: Array, T_far: Array) -> tuple[float, ...]:
        """How far to go straight back [m], one to try after the other; where the way lies there, no farther.

        Args:
            T_near: Head next to the person, (4, 4).
            T_far: Head at the other end, (4, 4).
        """
        across = T_near[:3, :3].T @ (T_far[:3, 3] - T_near[:3, 3])
        straight = np.linalg.norm(across[:2]) < _BEHIND and T_near[:3, 2] @ T_far[:3, 2] > _FACING
        behind = -float(across[2])
        return (max(behind, 0.0), *_BACKS) if straight and -_BEHIND < behind < _BACKS[0] else _BACKS

    def _foldings(self, near: Array, far: Array, side: Array) -> Iterator[list[Array]]:
        """Joints to pass between two postures: none where the head makes no detour, else the arm folded.

        Where the wrist cannot stay as it is while the arm folds, base, arm and wrist move one after
        the other, in every order that is clear.

        Raises:
            UnreachableError: When there are none.
        """
        direct = self._obstacle(near, far, side)
        if not direct:
            yield []
        folded_near = np.concatenate([self.home[:3], near[3:]])
        folded_far = np.concatenate([self.home[:3], far[3:]])
        reasons = [self._obstacle(*leg, side) for leg in ((near, folded_near), (folded_far, far))]
        if not any(reasons):
            yield [folded_near, folded_far]
        ends, turned = np.stack([near, far]), False
        for order in permutations(_GROUPS):
            way = [near]
            for group in order[:-1]:
                way.append(way[-1].copy())
                way[-1][group] = far[group]
            if not any(self._obstacle(*leg, side, ends) for leg in pairwise([*way, far])):
                turned = True
                yield way[1:]
        if direct and any(reasons) and not turned:
            raise UnreachableError(next(filter(None, reasons)))

    def _obstacle(self, start: Array, goal: Array, side: Array, ends: Array | None = None) -> str:
        """Say why a straight way in joint space is not clear; empty when it is.

        Args:
            start: Joints [rad], shape (6,).
            goal: Likewise.
            side: Head pose whose plane across z no link shall pass, (4, 4).
            ends: Postures (N, 6) that may pass it, since they are given; start and goal if left out.
        """
        joints = start + np.linspace(0.0, 1.0, 40)[:, None] * (goal - start)
        points, heads = self._towards(joints, side)
        given = points[[0, -1]] if ends is None else self._towards(ends, side)[0]
        allowed = max(float(side[:3, 2] @ side[:3, 3]), float(given.max()))
        if points.max() - allowed > _PLANE_SLACK:
            return f"the arm would pass its end by {(points.max() - allowed) * 1e3:.0f} mm towards the person"
        way = float(np.linalg.norm(np.diff(heads, axis=0), axis=1).sum())
        straight = float(np.linalg.norm(heads[-1] - heads[0]))
        if way > _DETOUR * straight + _DETOUR_FREE:
            return f"the head would travel {way:.2f} m for {straight:.2f} m"
        return ""

    def _towards(self, joints: Array, side: Array) -> tuple[Array, Array]:
        """How far wrist and head lie along z of `side` [m], (N, 5), and heads, (N, 3), of joints (N, 6)."""
        frames = self.arm.link_frames(joints)
        heads = frames[:, 6, :3, 3] + self.arm.tool.length * frames[:, 6, :3, 2]
        return np.concatenate([frames[:, 3:, :3, 3], heads[:, None]], axis=1) @ side[:3, 2], heads
