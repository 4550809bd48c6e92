"""Which distances, tilts and corners of the picture the views of a calibration cover, and what to do next.

A goal is a distance, a direction in which the camera was turned, or a corner of the depth picture that the
wall must fill; each wants a number of views. Sides are the camera's own: turned left means that the
camera looks to the left of the wall's normal.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.views.views import CalibrationView

EDGES = (0.4, 0.6, 0.75, 0.9, 1.1, 1.4, 2.0)  # [m]
DISTANCES = tuple(f"{near:g}-{far:g} m" for near, far in pairwise(EDGES))
TILTS = ("left", "right", "up", "down")
CORNERS = ("upper left", "upper right", "lower left", "lower right")
WANTED = {
    **dict(zip(DISTANCES, (3, 3, 3, 3, 3, 2), strict=True)),
    **dict.fromkeys(TILTS, 3),
    **dict.fromkeys(CORNERS, 5),
}  # views of each goal
LEAST_TURN = np.deg2rad(10.0)  # of a view that counts as tilted
GOOD_TURN = np.deg2rad(16.0)  # what is asked for
SAME_DISTANCE = 0.02  # [m] and
SAME_ANGLE = np.deg2rad(2.0)  # [rad]: closer views count as one
_NOT_WORTH = np.deg2rad(4.0)  # of turning
_CORNER_SHARE = 0.15  # of width and height that make a corner
_CORNER_FILLED = 0.5  # share of its pixels with depth


class ViewPose(NamedTuple):
    """Where a view was taken from: distance [m], turns [rad], and whether depth fills each corner."""

    distance: float
    left: float
    up: float
    corners: tuple[bool, bool, bool, bool] = (True, True, True, True)

    def same_as(self, other: "ViewPose") -> bool:
        """Whether two views tell the same."""
        apart = float(np.hypot(self.left - other.left, self.up - other.up))
        return abs(self.distance - other.distance) < SAME_DISTANCE and apart < SAME_ANGLE

    @property
    def goals(self) -> tuple[str, ...]:
        """What this view counts for."""
        found = [name for name, near, far in _bins() if near <= self.distance < far]
        turns = (self.left, -self.left, self.up, -self.up)
        found += [name for name, turn in zip(TILTS, turns, strict=True) if turn >= LEAST_TURN]
        found += [name for name, filled in zip(CORNERS, self.corners, strict=True) if filled]
        return tuple(found)


class Coverage(NamedTuple):
    """How many views each goal has."""

    counts: dict[str, int]
    views: int

    @property
    def missing(self) -> dict[str, int]:
        """Goals that want more views, and how many."""
        return {goal: want - self.counts[goal] for goal, want in WANTED.items() if self.counts[goal] < want}

    @property
    def share(self) -> float:
        """How much of all goals is reached, 0..1."""
        return 1.0 - sum(self.missing.values()) / sum(WANTED.values())

    def gain(self, pose: ViewPose) -> tuple[str, ...]:
        """The goals in want that a view would serve."""
        return tuple(goal for goal in pose.goals if goal in self.missing)


def pose_of(view: CalibrationView, unit: CameraUnit) -> ViewPose:
    """Sum up a view whose plane is known."""
    normal = view.plane.normal * -np.sign(view.plane.normal[2])
    height, width = view.depth.shape
    v, u = round(_CORNER_SHARE * height), round(_CORNER_SHARE * width)
    blind = int(np.ceil(unit.focal_baseline / view.distance))  # no depth left of it, ever
    corners = [
        float(np.mean(np.isfinite(view.depth[rows, columns]))) >= _CORNER_FILLED
        for rows in (slice(v), slice(height - v, None))
        for columns in (slice(blind, blind + u), slice(width - u, None))
    ]
    left, up = (float(np.arcsin(np.clip(-normal[axis], -1.0, 1.0))) for axis in (0, 1))
    return ViewPose(view.distance, left, up, tuple(corners))


def coverage_of(poses: Iterable[ViewPose]) -> Coverage:
    """Count the views of every goal."""
    poses = list(poses)
    counts = Counter(goal for pose in poses for goal in pose.goals)
    return Coverage({goal: counts[goal] for goal in WANTED}, len(poses))


def is_new(pose: ViewPose, poses: Sequence[ViewPose]) -> bool:
    """Whether a view differs from all others."""
    return not any(pose.same_as(other) for other in poses)


def next_pose(poses: Sequence[ViewPose], present: ViewPose | None = None) -> ViewPose:
    """A pose that serves goals in want, near the present one; differs from all others.

    Args:
        poses: Views taken.
        present: Where the camera is; None if unknown.
    """
    missing = coverage_of(poses).missing
    here = present.distance if present else 0.8
    bins = [(name, near, far) for name, near, far in _bins() if name in missing] or _bins()[1:4]
    _, near, far = min(bins, key=lambda entry: abs(here - _middle(*entry[1:])))
    turn = {name: GOOD_TURN if name in missing else 0.0 for name in TILTS}
    left = turn["left"] if missing.get("left", 0) >= missing.get("right", 0) else -turn["right"]
    up = turn["up"] if missing.get("up", 0) >= missing.get("down", 0) else -turn["down"]
    tries = [
        ViewPose(near + share * (far - near), factor * left, factor * up)
        for factor in (1.0, 1.3, 0.8, 1.5)
        for share in (0.5, 0.2, 0.8, 0.35, 0.65)
    ]
    return next((pose for pose in tries if is_new(pose, poses)), tries[0])


def instruction(poses: Sequence[ViewPose], present: ViewPose | None = None) -> str:
    """What to do next, in plain words.

    Args:
        poses: Views taken.
        present: What the camera sees now; None if it sees no board.
    """
    coverage = coverage_of(poses)
    if not coverage.missing:
        return "all is covered"
    if present and is_new(present, poses) and coverage.gain(present):
        return "hold still"
    goal = next_pose(poses, present)
    corners = [name for name in CORNERS if name in coverage.missing]
    if set(coverage.missing) <= set(CORNERS):
        return f"let the wall fill the {corners[0]} corner of the picture, at {goal.distance:.2f} m"
    return _directions(goal, present) or "move a little, to a new place"


def gain_words(goals: Sequence[str]) -> str:
    """What a view serves, in words."""
    words = [f"turned {goal}" if goal in TILTS else goal for goal in goals if goal not in CORNERS]
    corners = sum(goal in CORNERS for goal in goals)
    words += [f"{corners} corner{'s' if corners > 1 else ''}"] if corners else []
    return ", ".join(words) or "nothing that was missing"


def _directions(goal: ViewPose, present: ViewPose | None) -> str:
    """How to get from one pose to another; empty where they are the same."""
    here = present or ViewPose(goal.distance, 0.0, 0.0)
    words = [] if present else [f"show the board from {goal.distance:.2f} m"]
    if abs(goal.distance - here.distance) >= SAME_DISTANCE:
        words.append(f"move {'back' if goal.distance > here.distance else 'closer'} to {goal.distance:.2f} m")
    turns = []
    for change, sides in ((goal.left - here.left, TILTS[:2]), (goal.up - here.up, TILTS[2:])):
        if abs(change) > _NOT_WORTH:
            turns.append(f"{abs(np.rad2deg(change)):.0f} deg {sides[0] if change > 0.0 else sides[1]}")
    words += [f"turn {' and '.join(turns)}"] if turns else []
    return ", ".join(words)


def _bins() -> list[tuple[str, float, float]]:
    return [(name, *edges) for name, edges in zip(DISTANCES, pairwise(EDGES), strict=True)]


def _middle(near: float, far: float) -> float:
    return 0.5 * (near + far)
