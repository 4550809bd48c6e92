"""A coarse cloud of what the camera sees within the arm's reach, so that the arm does not run into it.

Coarse on purpose: it has to say where a body is, not what it looks like. What the arm covers just now is
remembered for a while, for the arm hides just what is nearest to it.
"""

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from numpy.typing import NDArray

from bathbot_localize.arm.arm_mask import near_arm
from bathbot_localize.target.localizer import Frame

Array = NDArray[np.float64]
_SAMPLES = 3.0  # points across a voxel, at 1 m
_LEAST = 3  # points in a voxel; fewer are noise at an edge
_BEHIND = 0.03  # [m] by which depths may differ and still be one thing
_WIDER = 0.02  # [m] that the arm is masked wider than for skin: what is left over here would stop it


class BodyCloud:
    """What was seen up to now. Not thread-safe."""

    def __init__(self, voxel: float, memory: float, arm_margin: float) -> None:
        """Begin with nothing.

        Args:
            voxel: Edge of a cell that becomes one point [m].
            memory: For how long hidden places are believed to be as they were [s].
            arm_margin: By which the arm is masked wider than it is, for skin [m].
        """
        self._voxel, self._memory, self._margin = voxel, memory, arm_margin + _WIDER
        self._points, self._stamps = np.empty((0, 3)), np.empty(0)

    def update(self, frame: Frame, stamp: float) -> Array:
        """Take in a picture of a time [s]; give all points known now, shape (N, 3), base frame [m]."""
        camera, T_base_depth = frame.depth_camera, frame.T_base_colour @ frame.T_colour_depth
        stride = max(int(self._voxel / _SAMPLES * camera.fx), 1)
        depth = frame.depth[::stride, ::stride]
        rows, columns = np.indices(depth.shape) * stride
        points = transform_points(T_base_depth, camera.deproject(np.stack([columns, rows], axis=-1), depth))
        arm = near_arm(points, frame.shape.capsules, frame.T_base_link, self._margin)
        workspace = frame.shape.workspace
        near = (
            np.linalg.norm(points - workspace.shoulder, axis=-1) <= workspace.within
        )  # not where there is no depth
        fresh = self._centres(points[near & ~arm])
        known = transform_points(inverse(T_base_depth), self._points)
        hidden = _hidden(camera.project(known) / stride, known[:, 2], depth, arm)
        kept = (
            hidden
            & (stamp - self._stamps <= self._memory)
            & ~np.isin(self._cells(self._points), self._cells(fresh))
        )
        self._points = np.concatenate([fresh, self._points[kept]])
        self._stamps = np.concatenate([np.full(len(fresh), stamp), self._stamps[kept]])
        return self._points

    def _cells(self, points: Array) -> NDArray[np.int64]:
        """One number for the voxel of each point, shape (N, 3) -> (N,)."""
        x, y, z = np.floor(points / self._voxel).astype(np.int64).T + 2**20
        return (x << 42) + (y << 21) + z

    def _centres(self, points: Array) -> Array:
        """Mean of the points, shape (N, 3), in each voxel that holds enough of them."""
        _, where, counts = np.unique(self._cells(points), return_inverse=True, return_counts=True)
        sums = [np.bincount(where, points[:, axis], len(counts)) for axis in range(3)]
        return (np.stack(sums, axis=-1) / counts[:, None])[counts >= _LEAST]


def _hidden(
    pixels: Array, depths: Array, depth: NDArray[np.float32], arm: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which known points the picture says nothing about: before them is the arm, something else or no depth.

    Args:
        pixels: Of the points (u, v), shape (M, 2), in the picture `depth`.
        depths: Of the points [m], shape (M,).
        depth: Picture [m], shape (H, W).
        arm: Which of its pixels show the arm.
    """
    inside = ((pixels > -0.5) & (pixels < np.array(depth.shape[::-1]) - 0.5)).all(axis=-1)
    columns, rows = np.where(inside, np.round(pixels).T, 0).astype(int)
    seen = depth[rows, columns]
    return inside & (np.isnan(seen) | arm[rows, columns] | (seen < depths - _BEHIND))
