"""How much of the planned patch of skin came under the brush.

The patch is the skin inside the outline (convex hull) of the planned path, seen along the mean
approach direction; skin between two scan lines belongs to it, whether the brush reaches it or not.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull, Delaunay, QhullError, cKDTree

Array = NDArray[np.float64]
_DEPTH = 0.05  # [m] skin farther than this from the path's mean plane is another part of the body
_WINDOW = 1.0  # [s] the body is taken to stand still for so long
_SPACING = 0.003  # [m] between samples of skin


class Coverage(NamedTuple):
    """Samples of the patch, each standing for the same area.

    Attributes:
        samples: Positions on the skin in the plane of the patch [m], shape (S, 2).
        covered: Which of them came under the brush in contact, shape (S,).
        outline: Corners of the patch in the same plane [m], shape (C, 2).
    """

    samples: Array
    covered: NDArray[np.bool_]
    outline: Array

    @property
    def fraction(self) -> float:
        """Share of the patch that was covered, 0..1; NaN when there is no patch."""
        return float(self.covered.mean()) if len(self.covered) else float("nan")


class PatchFrame(NamedTuple):
    """A plane through the planned path: axes in its rows, shape (3, 3), the last one into the skin."""

    origin: Array
    axes: Array

    def flatten(self, points: ArrayLike) -> Array:
        """Give in-plane coordinates and depth [m] of points, shape (..., 3)."""
        return (np.asarray(points, dtype=float) - self.origin) @ self.axes.T


def patch_frame(planned: ArrayLike) -> PatchFrame:
    """Lay a plane through planned poses, shape (M, 4, 4): normal to their mean approach direction."""
    planned = np.asarray(planned, dtype=float)
    inward = planned[:, :3, 2].mean(axis=0)
    inward /= np.linalg.norm(inward)
    upward = np.array([0.0, 0.0, 1.0]) if abs(inward[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    first = np.cross(upward, inward)
    first /= np.linalg.norm(first)
    return PatchFrame(planned[:, :3, 3].mean(axis=0), np.array([first, np.cross(inward, first), inward]))


def skin_samples(
    vertices: Array, faces: NDArray[np.int32], keep: NDArray[np.bool_], seed: int = 0
) -> tuple[Array, Array]:
    """Spread samples evenly over the area of some triangles.

    Args:
        vertices: Points of the skin [m], shape (V, 3).
        faces: Corners of the triangles, shape (F, 3).
        keep: Which triangles take part, shape (F,).
        seed: Of the random spread.

    Returns:
        Triangle of each sample, shape (S,), and its weights of the three corners, shape (S, 3).
    """
    chosen = np.flatnonzero(keep)
    corners = vertices[faces[chosen]]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    random = np.random.default_rng(seed)
    count = int(area.sum() / _SPACING**2)
    triangles = random.choice(chosen, size=count, p=area / area.sum()) if count else np.zeros(0, dtype=int)
    u, v = random.random((2, count))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    return triangles, np.stack([1.0 - u - v, u, v], axis=-1)


def coverage(
    planned: ArrayLike,
    faces: NDArray[np.int32],
    skin_faces: NDArray[np.bool_],
    vertices_at: Callable[[float], Array],
    times: ArrayLike,
    brush: ArrayLike,
    radius: float = SCRUB_HEAD.brush_radius,
) -> Coverage:
    """Find the share of the patch that came under the brush while the body moved.

    Args:
        planned: Poses of the path, shape (M, 4, 4).
        faces: Triangles of the body, shape (F, 3).
        skin_faces: Which of them belong to the region, shape (F,).
        vertices_at: Gives the points of the body in the base frame [m], shape (V, 3), at a time [s].
        times: When the brush touched [s], increasing, shape (N,).
        brush: Where the middle of the bent brush was then [m], shape (N, 3).
        radius: Of the brush [m].
    """
    planned, times = np.asarray(planned, dtype=float), np.asarray(times, dtype=float)
    brush = np.asarray(brush, dtype=float).reshape(-1, 3)
    nothing = Coverage(np.zeros((0, 2)), np.zeros(0, dtype=bool), np.zeros((0, 2)))
    if len(planned) < 3 or len(times) == 0:
        return nothing
    frame = patch_frame(planned)
    path = frame.flatten(planned[:, :3, 3])[:, :2]
    try:
        outline = path[ConvexHull(path).vertices]
    except QhullError:  # a straight path has no area
        return nothing
    start = vertices_at(float(times[0]))
    flat = frame.flatten(start[faces].mean(axis=1))
    inside = Delaunay(outline).find_simplex(flat[:, :2]) >= 0
    keep = skin_faces & inside & (np.abs(flat[:, 2]) < _DEPTH) & _faces_towards(start, faces, frame)
    triangles, weights = skin_samples(start, faces, keep)
    covered = np.zeros(len(triangles), dtype=bool)
    windows = ((times - times[0]) / _WINDOW).astype(int)
    for window in np.unique(windows):
        now = windows == window
        samples = np.einsum("sc,scx->sx", weights, vertices_at(float(times[now].mean()))[faces[triangles]])
        near, _ = cKDTree(brush[now]).query(samples, distance_upper_bound=radius)
        covered |= np.isfinite(near)
    samples = np.einsum("sc,scx->sx", weights, start[faces[triangles]])
    return Coverage(frame.flatten(samples)[:, :2], covered, outline)


def _faces_towards(vertices: Array, faces: NDArray[np.int32], frame: PatchFrame) -> NDArray[np.bool_]:
    """Tell which triangles look against the approach direction: the far side of a limb stays out."""
    corners = vertices[faces]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return outward @ frame.axes[2] < 0.0
