"""How deep a path may press: as far as the bristles give below the skin that camera and force agree on.

Where the body cloud knows the skin near a pose, its height there counts, shifted by how far the cloud is off
where the head feels the skin now. Where it does not, the skin counts as flat as at the touch, and may curve
away from there. Errors of both are allowed for once, by `TOLERANCE`. Whatever goes deeper, or does not point
into the skin, is refused before it moves.
"""

from typing import NamedTuple

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from numpy.typing import NDArray

from bathbot_scrub.arm.errors import InvalidPoseError

Array = NDArray[np.float64]
# [m] by which skin may be deeper than known: 4 mm of breath, 2 mm of camera and hand-eye, and as much again
# would be a shift of the person by 15 mm before the head feels it
TOLERANCE = 0.008
CURVING = 0.06  # [m] radius by which skin that nobody sees may curve away from the plane of the touch
FARTHEST = 0.02  # [m] by which it may do so at most: as far as a planner follows skin that moves
MOST_TILT = np.radians(66.0)  # off the skin's normal: slopes of 60 deg are planned, turns of 6 deg left out
_AGREE = 0.02  # [m] by which camera and force may differ; beyond, the force counts no more than that
_BESIDE, _WIDTH = 0.035, 0.012  # [m] from a pose's axis to points that count there; of their weights
_ABOVE, _BELOW = 0.08, 0.04  # [m] from a tip to points of its skin, along the axis
_REACH = 0.09  # [m] from a tip to the farthest of these points
_AT_ONCE = 16  # poses
_FLAT = (0.004 / 0.3) ** 2  # [m^2] noise of points over slope of the skin across a pose, squared
_KNOWN = 0.8  # weight of points from which they tell the skin
_NORMAL_POINTS, _THIN = 6, 0.2  # points that tell a normal; their variance along it over that across
_ACROSS = 0.008  # [m] that they spread at least both ways across it: a row of points has no normal


class Felt(NamedTuple):
    """Where the head stands, and how hard it feels skin there."""

    T_base_head: Array  # (4, 4)
    force: float  # [N]


class Skin(NamedTuple):
    """All that is known of where the skin is."""

    touch: Felt  # where the arm came into contact
    now: Felt
    cloud: Array  # (M, 3) base frame [m] what the camera saw; (0, 3): nothing


class Bristles(NamedTuple):
    """What the force says of how far they are bent."""

    contact: float  # [N] from which skin counts as felt
    stiffness: float  # [N/m]
    give: float = SCRUB_HEAD.give  # [m]


class Depths(NamedTuple):
    """For each of N poses."""

    depth: Array  # (N,) [m] of the bristles' tip, were they not bent, below the skin known there
    most: Array  # (N,) [m] allowed
    seen: NDArray[np.bool_]  # (N,) whether the cloud knows the skin there
    tilt: Array  # (N,) [rad] of the head off the normal known there


def check_depth(T_base_heads: Array, skin: Skin, bristles: Bristles) -> None:
    """Refuse head poses, shape (N, 4, 4), that press deeper than the bristles give, or past the skin.

    Raises:
        InvalidPoseError: With the pose, the value, the limit and what to try.
    """
    found = depths(T_base_heads, skin, bristles)
    worst = int(np.argmax(found.depth - found.most))
    which = f"pose {worst} of {len(T_base_heads)}"
    if not found.depth[worst] <= found.most[worst]:
        by = "body cloud and force" if found.seen[worst] else "the touch: no body cloud is there"
        raise InvalidPoseError(
            f"{which} lies {found.depth[worst] * 1e3:.0f} mm below the skin known by {by}; the most there is "
            f"{found.most[worst] * 1e3:.0f} mm; plan on a newer surface, or retract and approach again"
        )
    worst = int(np.argmax(found.tilt))
    which = f"pose {worst} of {len(T_base_heads)}"
    if not found.tilt[worst] <= MOST_TILT:
        raise InvalidPoseError(
            f"{which} points {np.degrees(found.tilt[worst]):.0f} deg past the skin's normal; the most is "
            f"{np.degrees(MOST_TILT):.0f} deg; turn the head's z axis into the skin"
        )


def depths(T_base_heads: Array, skin: Skin, bristles: Bristles) -> Depths:
    """How deep head poses, shape (N, 4, 4), lie in the skin, and how deep they may."""
    places = np.concatenate([T_base_heads[:, :3, 3], skin.now.T_base_head[None, :3, 3]])
    low, high = places.min(axis=0) - _REACH, places.max(axis=0) + _REACH
    skin = skin._replace(cloud=skin.cloud[((skin.cloud >= low) & (skin.cloud <= high)).all(axis=1)])
    height, seen = _heights(T_base_heads, skin.cloud)
    depth = np.where(seen, _shift(skin, bristles) - height, np.inf)
    most = np.full(len(T_base_heads), bristles.give + TOLERANCE)
    for felt in (skin.touch, skin.now):
        below, allowed = _below_plane(T_base_heads, felt, bristles)
        better = ~seen & (below - allowed < depth - most)
        depth, most = np.where(better, below, depth), np.where(better, allowed, most)
    return Depths(depth, most, seen, _tilts(T_base_heads, skin))


def _below_plane(poses: Array, felt: Felt, bristles: Bristles) -> tuple[Array, Array]:
    """Depth of tips below the plane of skin that is felt, and how deep they may be there, shape (N,) [m]."""
    inward = felt.T_base_head[:3, 2]
    offset = poses[:, :3, 3] - felt.T_base_head[:3, 3]
    along = offset @ inward
    beside = np.linalg.norm(offset - along[:, None] * inward, axis=1)
    curved = np.minimum(beside**2 / (2.0 * CURVING), FARTHEST)
    return along + _bend(felt, bristles), bristles.give + TOLERANCE + curved


def _bend(felt: Felt, bristles: Bristles) -> float:
    """How far the bristles are bent [m]."""
    return float(np.clip(felt.force / bristles.stiffness, 0.0, bristles.give))


def _shift(skin: Skin, bristles: Bristles) -> float:
    """How much nearer to the arm the force feels the skin than the cloud tells [m]; 0 where it cannot say."""
    height, seen = _heights(skin.now.T_base_head[None], skin.cloud)
    if not seen[0] or not np.isfinite(skin.now.force):
        return 0.0
    nearer = _bend(skin.now, bristles) + float(height[0])
    if skin.now.force < bristles.contact:  # not felt: it is at the tip or deeper
        nearer = min(nearer, 0.0)
    return float(np.clip(nearer, -_AGREE, _AGREE))


def _heights(poses: Array, cloud: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Where the cloud has skin on the axes of head poses, from their tips inwards [m]; whether it knows.

    A plane through the points about each axis, which does not slope unless they say so.
    """
    if len(poses) > _AT_ONCE:  # memory is bounded
        halves = [_heights(half, cloud) for half in np.array_split(poses, 2)]
        return np.concatenate([half[0] for half in halves]), np.concatenate([half[1] for half in halves])
    local = np.einsum("nmi,nij->nmj", cloud[None] - poses[:, None, :3, 3], poses[:, :3, :3])
    beside = np.linalg.norm(local[..., :2], axis=-1)
    near = (beside <= _BESIDE) & (local[..., 2] >= -_ABOVE) & (local[..., 2] <= _BELOW)
    weights = np.where(near, np.exp(-0.5 * (beside / _WIDTH) ** 2), 0.0)
    total = weights.sum(axis=1)
    terms = np.concatenate([np.ones_like(local[..., :1]), local[..., :2]], axis=-1)
    normal = np.einsum("nm,nmi,nmj->nij", weights, terms, terms) + np.diag([1e-9, _FLAT, _FLAT])
    heights = np.linalg.solve(normal, np.einsum("nm,nmi,nm->ni", weights, terms, local[..., 2])[..., None])
    return heights[:, 0, 0], total >= _KNOWN


def _tilts(poses: Array, skin: Skin) -> Array:
    """Angle of head poses off the normal known there [rad], shape (N,): of the cloud and of the touch."""
    axes = poses[:, :3, 2]
    tilts = np.arccos(np.clip(axes @ skin.touch.T_base_head[:3, 2], -1.0, 1.0))
    for index, pose in enumerate(poses):
        points = skin.cloud[np.linalg.norm(skin.cloud - pose[:3, 3], axis=1) <= _BESIDE]
        if len(points) < _NORMAL_POINTS:
            continue
        spread, directions = np.linalg.eigh(np.cov(points.T))
        if spread[0] <= _THIN * spread[1] and spread[1] >= _ACROSS**2:
            tilts[index] = max(tilts[index], np.arccos(min(abs(axes[index] @ directions[:, 0]), 1.0)))
    return tilts
