"""Poses of the scrub head on a path, Eqs. (14)-(18).

The head's frame: z is the approach direction a = -K (into the skin), y the direction of travel o
(the tangent I projected onto the skin), x = m = K x I = y x z. Only so the columns [m o a] of Eq. (14)
are right-handed. The frame's origin is the tip of the unbent bristles; a path that presses them
by `compression` runs that far below the skin.

Eq. (18) turns the head only where the path bends by 6 deg or more between neighbouring steps. On a
smooth arc every step stays below that and the head would never turn, so we compare the wanted
orientation with the last one APPLIED, and we compare whole orientations: Eq. (18) sees the bend of
the path but not the roll of the skin about it.
"""

from typing import NamedTuple

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD, ScrubHead
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
TURN_THRESHOLD = np.radians(6.0)  # theta of Eq. (18) [rad]


class Turning(NamedTuple):
    """How the head stands and turns at one point of a path.

    Attributes:
        rotation: Rotation applied, shape (3, 3).
        rate: Rotation vector per step in the head's frame [rad], shape (3,).
    """

    rotation: Array
    rate: Array


def head_rotations(normals: ArrayLike, travel: ArrayLike) -> Array:
    """Rotations [m o a] of Eq. (14), shape (..., 3, 3).

    Args:
        normals: Outward unit normals of the skin, shape (..., 3).
        travel: Direction of travel, any length, not along the normal, shape (..., 3).
    """
    normals, travel = np.asarray(normals, dtype=float), np.asarray(travel, dtype=float)
    z = -normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    y = travel - np.sum(travel * z, axis=-1, keepdims=True) * z
    y /= np.linalg.norm(y, axis=-1, keepdims=True)
    return np.stack([np.cross(y, z), y, z], axis=-1)


def head_poses(rotations: ArrayLike, points: ArrayLike) -> Array:
    """Poses of Eq. (14), shape (..., 4, 4), from rotations (..., 3, 3) and points [m] (..., 3)."""
    points = np.asarray(points, dtype=float)
    poses = np.broadcast_to(np.eye(4), (*points.shape[:-1], 4, 4)).copy()
    poses[..., :3, :3], poses[..., :3, 3] = rotations, points
    return poses


def flange_poses(T_base_head: ArrayLike, head: ScrubHead = SCRUB_HEAD) -> Array:
    """Poses of the flange, shape (..., 4, 4), that hold the head at T_base_head: Eqs. (15)-(17)."""
    return np.asarray(T_base_head) @ head.T_head_flange


def step_angles(points: ArrayLike) -> Array:
    """Angles theta_i of Eq. (18) [rad], shape (N - 2,), between neighbouring steps of points (N, 3)."""
    steps = np.diff(np.asarray(points, dtype=float), axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    return np.arccos(np.clip(np.sum(steps[:-1] * steps[1:], axis=1), -1.0, 1.0))


def turns_as_printed(points: ArrayLike, threshold: float = TURN_THRESHOLD) -> Array:
    """Indices of points, shape (K,), at which Eq. (18) to the letter would turn the head."""
    return np.flatnonzero(step_angles(points) >= threshold) + 1


def turns(rotations: ArrayLike, applied: ArrayLike, threshold: float = TURN_THRESHOLD) -> list[int]:
    """Where the head is turned: each time it would be off its last applied orientation by the threshold.

    Args:
        rotations: Wanted rotations along the path, shape (N, 3, 3).
        applied: The rotation applied before the first of them, shape (3, 3).
        threshold: Angle theta [rad].
    """
    current, indices = np.asarray(applied, dtype=float), []
    least_trace = 1.0 + 2.0 * np.cos(threshold)  # trace R = 1 + 2 cos(angle)
    for index, wanted in enumerate(np.asarray(rotations, dtype=float)):
        if np.sum(current * wanted) <= least_trace:
            current = wanted
            indices.append(index)
    return indices


def held_rotations(rotations: Array, applied: Array, threshold: float = TURN_THRESHOLD) -> Array:
    """Rotations that stand still between turns and jump at them, shape (N, 3, 3)."""
    held = np.broadcast_to(applied, rotations.shape).copy()
    for index in turns(rotations, applied, threshold):
        held[index:] = rotations[index]
    return held


def turned_rotations(
    rotations: Array, start: Turning, rates: Array, threshold: float = TURN_THRESHOLD
) -> Array:
    """Rotations that reach each turn smoothly instead of jumping at it, shape (N, 3, 3).

    The same turns as `held_rotations`, and one at the end. Between them the head turns along a cubic
    with the wanted rates at both ends: a jump of 6 deg from one point to the next would swing the
    wrist by 28 mm, and an even turn would still jolt it at every change of rate. Where a cubic would
    stray from the wanted by more than a quarter of the threshold, the head is turned halfway too.

    Args:
        rotations: Wanted rotations at equal steps, shape (N, 3, 3).
        start: Rotation and rate applied one step before the first of them.
        rates: Wanted rates at each of them, as rotation vectors per step in the head's frame, shape (N, 3).
        threshold: Angle theta [rad].
    """
    result, done, before = np.empty_like(rotations), -1, start
    for key in sorted({*turns(rotations, start.rotation, threshold), len(rotations) - 1}):
        while done < key:
            until = key
            while True:
                piece = _turn_piece(before, Turning(rotations[until], rates[until]), until - done)
                traces = np.sum(piece * rotations[done + 1 : until + 1], axis=(1, 2))
                if until == done + 1 or traces.min() >= 1.0 + 2.0 * np.cos(0.25 * threshold):
                    break
                until = (done + 1 + until) // 2
            result[done + 1 : until + 1] = piece
            done, before = until, Turning(rotations[until], rates[until])
    return result


def _turn_piece(start: Turning, end: Turning, steps: int) -> Array:
    """Rotations of the cubic from `start` (left out) to `end`, shape (steps, 3, 3)."""
    t = (np.arange(1, steps + 1) / steps)[:, None]
    whole = Rotation.from_matrix(start.rotation.T @ end.rotation).as_rotvec()
    bend = ((t**3 - 2.0 * t**2 + t) * start.rate + (t**3 - t**2) * end.rate) * steps
    vectors = (3.0 * t**2 - 2.0 * t**3) * whole + bend
    return start.rotation @ Rotation.from_rotvec(vectors).as_matrix()


def rotation_rates(rotations: ArrayLike) -> Array:
    """Rotation vectors per step in the head's frame, shape (N, 3), by central differences of (N, 3, 3)."""
    rotations = np.asarray(rotations, dtype=float)
    steps = Rotation.from_matrix(np.swapaxes(rotations[:-1], -1, -2) @ rotations[1:]).as_rotvec()
    steps = steps.reshape(-1, 3)
    padded = np.concatenate([steps[:1], steps, steps[-1:]])
    return 0.5 * (padded[:-1] + padded[1:])
