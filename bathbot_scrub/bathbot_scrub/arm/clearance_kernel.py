"""Distances of many points to capsules along a path, compiled; see `branch_kernel` for what that costs."""

from math import sqrt

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def fill_clearances(ends, radii, touches, points, spared, interest, clearances, capsules, nearest):
    """The least distance of any point to the surface of any capsule, at each sample of a path.

    Args:
        ends: Of the capsules' axes in the base frame [m], shape (N, C, 2, 3).
        radii: Of the capsules [m], shape (C,).
        touches: Which capsules may touch spared points, shape (C,).
        points: Base frame [m], shape (M, 3).
        spared: Which points may be touched, shape (M,).
        interest: Distances above are not told apart: `interest` stands for all of them [m].
        clearances: Taken for the result [m], shape (N,); negative inside a capsule.
        capsules: Taken for the capsule of each, shape (N,); -1 where none is that near.
        nearest: Taken for the point of each, shape (N,).
    """
    for sample in range(len(ends)):
        best, capsules[sample], nearest[sample] = interest, -1, -1
        for capsule in range(len(radii)):
            start, end = ends[sample, capsule, 0], ends[sample, capsule, 1]
            mid_x, mid_y, mid_z = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2, (start[2] + end[2]) / 2
            half = sqrt((end[0] - mid_x) ** 2 + (end[1] - mid_y) ** 2 + (end[2] - mid_z) ** 2)
            around = max(best + radii[capsule], 0.0) + half
            for point in range(len(points)):
                px, py, pz = points[point, 0], points[point, 1], points[point, 2]
                outer = (px - mid_x) ** 2 + (py - mid_y) ** 2 + (pz - mid_z) ** 2
                if outer > around * around or (spared[point] and touches[capsule]):
                    continue
                distance = _to_axis(points[point], ends[sample, capsule]) - radii[capsule]
                if distance < best:
                    best, capsules[sample], nearest[sample] = distance, capsule, point
                    around = max(best + radii[capsule], 0.0) + half
        clearances[sample] = best


@njit(cache=True, nogil=True)
def beside(ends, radii, touches, points, spared, margin):
    """Which points, shape (M, 3), lie within `margin` [m] of a capsule, ends (C, 2, 3); else as above."""
    near = np.zeros(len(points), np.bool_)
    for point in range(len(points)):
        for capsule in range(len(radii)):
            if not (spared[point] and touches[capsule]):
                distance = _to_axis(points[point], ends[capsule])
                near[point] |= distance - radii[capsule] < margin
    return near


@njit(cache=True, nogil=True, inline="always")
def _to_axis(point, ends):
    """Distance [m] of a point, shape (3,), to the segment between two ends, shape (2, 3)."""
    square = share = 0.0
    for axis in range(3):
        along = ends[1, axis] - ends[0, axis]
        square += along * along
        share += along * (point[axis] - ends[0, axis])
    share = min(max(share / square, 0.0), 1.0) if square > 0.0 else 0.0
    total = 0.0
    for axis in range(3):
        total += (point[axis] - ends[0, axis] - share * (ends[1, axis] - ends[0, axis])) ** 2
    return sqrt(total)


@njit(cache=True, nogil=True)
def within(points, centres, radius):
    """Which points, shape (M, 3), lie within `radius` [m] of any of the centres, shape (K, 3)."""
    near = np.zeros(len(points), np.bool_)
    for point in range(len(points)):
        for centre in range(len(centres)):
            square = 0.0
            for axis in range(3):
                square += (points[point, axis] - centres[centre, axis]) ** 2
            if square <= radius * radius:
                near[point] = True
                break
    return near
