"""A coarse cloud of what the camera sees within the arm's reach, so that the arm does not run into it.

Coarse on purpose: it has to say where a body is, not what it looks like. What the arm covers just now is
remembered, for the arm hides just what is nearest to it. Where a picture has no depth it says nothing: what
stood there stays, and a picture that says nothing of too many places vouches for none. Stereo sees single
places in the air, between the edge of a thing and what is behind it: a place that stands alone is believed
when two pictures in a row show it.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation
from scipy.spatial import KDTree

from bathbot_localize.arm.arm_mask import near_arm
from bathbot_localize.target.localizer import Frame

Array = NDArray[np.float64]
_SAMPLES = 3.0  # points across a voxel, at 1 m
_LEAST = 3  # points in a voxel; fewer are noise at an edge
_BEHIND = 0.03  # [m] by which depths may differ and still be one thing
_LENS = 0.25  # [m] nearer than which nothing is measured: it is on the lens, or an error
_ONE_BODY = 0.4  # [m] before a place: what hides it from nearer to the lens is no hand of the same person
_BASELINE = 0.1  # [m] between the two cameras of a D455: how wide a shadow stereo can have
_WIDER = 0.02  # [m] that the arm is masked wider than for skin: what is left over here would stop it
_BESIDE = 2.0  # voxels from something seen, within which lost depth is a matter of its edge
_COMPANY = 2  # other places within `_BESIDE` without which a place stands alone
_UNSEEN = 0.1  # share of places of which a picture may say nothing and still vouch for the rest


class Known(NamedTuple):
    """What stands within the arm's reach."""

    points: Array  # (N, 3) base frame [m]
    stamp: float  # [s] of the newest picture that vouches for them; -inf: none ever did
    unseen: float  # share of them of which the newest picture says nothing, 0..1


class _Said(NamedTuple):
    """What a picture says of known points, masks of shape (M,)."""

    there: NDArray[np.bool_]  # something is, though too few points of its voxel are seen
    covered: NDArray[np.bool_]  # the arm is before it
    behind: NDArray[np.bool_]  # something else is, near enough to be of the same body
    dark: NDArray[np.bool_]  # nothing: no depth there, or something far before it


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
        self._doubtful = np.empty((0, 3))  # seen alone in the newest picture
        self._vouched = -np.inf

    def update(self, frame: Frame, stamp: float, beside: Iterable[Mapping[str, Array]] = ()) -> Known:
        """Take in a picture; give all points known now.

        Time frees no place: it stays until it is looked through. One that the arm hides for longer than the
        memory counts as unseen. One without depth does so at once, and is forgotten after the memory only
        where nearly all others are seen.

        Args:
            frame: The picture.
            stamp: Its time [s].
            beside: Where else the links may have been then, for no two clocks agree: poses as in the frame.
        """
        camera, T_base_depth = frame.depth_camera, frame.T_base_colour @ frame.T_colour_depth
        stride = max(int(self._voxel / _SAMPLES * camera.fx), 1)
        depth = frame.depth[::stride, ::stride]
        depth = np.where(depth > _LENS, depth, np.nan)
        rows, columns = np.indices(depth.shape) * stride
        points = transform_points(T_base_depth, camera.deproject(np.stack([columns, rows], axis=-1), depth))
        arm = np.any(
            [
                near_arm(points, frame.shape.capsules, links, self._margin)
                for links in (frame.T_base_link, *beside)
            ],
            axis=0,
        )
        arm |= _shadow(arm, depth, camera.fx / stride)
        workspace = frame.shape.workspace
        near = (
            np.linalg.norm(points - workspace.shoulder, axis=-1) <= workspace.within
        )  # not where there is no depth
        fresh = self._believed(self._centres(points[near & ~arm]))
        known = transform_points(inverse(T_base_depth), self._points)
        said = _said(camera.project(known) / stride, known[:, 2], depth, arm, 0.5 * self._voxel)
        remembered = stamp - self._stamps <= self._memory
        other = ~np.isin(self._cells(self._points), self._cells(fresh))
        alone = said.dark & (_distances(self._points, fresh) > _BESIDE * self._voxel)
        unseen = other & (alone | (said.covered & ~remembered))
        kept = other & (said.there | said.covered | said.behind | said.dark)
        share = float(unseen.sum() / max(len(fresh) + kept.sum(), 1))
        if share <= _UNSEEN and len(fresh) + kept.sum():
            self._vouched = stamp
            kept &= remembered | ~said.dark
        self._points = np.concatenate([fresh, self._points[kept]])
        self._stamps = np.concatenate([np.full(len(fresh), stamp), self._stamps[kept]])
        return Known(self._points, self._vouched, share)

    def _believed(self, seen: Array) -> Array:
        """Those of the places seen in a picture, shape (N, 3), that are no lonely news."""
        known = np.isin(self._cells(seen), self._cells(self._points))
        others = self._points[~np.isin(self._cells(self._points), self._cells(seen))]
        alone = _distances(seen, np.concatenate([seen, others]), _COMPANY + 1) > _BESIDE * self._voxel
        doubtful = alone & ~known & (_distances(seen, self._doubtful) > self._voxel)
        self._doubtful = seen[alone & ~known]
        return seen[~doubtful]

    def _cells(self, points: Array) -> NDArray[np.int64]:
        """One number for the voxel of each point, shape (N, 3) -> (N,)."""
        x, y, z = np.floor(points / self._voxel).astype(np.int64).T + 2**20
        return (x << 42) + (y << 21) + z

    def _centres(self, points: Array) -> Array:
        """Mean of the points, shape (N, 3), in each voxel that holds enough of them."""
        _, where, counts = np.unique(self._cells(points), return_inverse=True, return_counts=True)
        sums = [np.bincount(where, points[:, axis], len(counts)) for axis in range(3)]
        return (np.stack(sums, axis=-1) / counts[:, None])[counts >= _LEAST]


def _distances(points: Array, others: Array, which: int = 1) -> Array:
    """From each point, shape (M, 3), to the nearest of the others, shape (N, 3) -> (M,); inf without any.

    With `which` 2 to the second nearest, and so on.
    """
    return (
        KDTree(others).query(points, [which])[0][:, 0]
        if len(points) and len(others)
        else np.full(len(points), np.inf)
    )


def _shadow(arm: NDArray[np.bool_], depth: NDArray[np.float32], fx: float) -> NDArray[np.bool_]:
    """Where a picture has no depth because one of the two stereo cameras sees the arm there, shape (H, W).

    Args:
        arm: Which pixels show the arm, shape (H, W).
        depth: Picture [m], shape (H, W).
        fx: Focal length [px].
    """
    if not arm.any():
        return arm
    width = int(np.ceil(_BASELINE * fx / float(depth[arm].min())))
    return binary_dilation(arm, np.ones((1, 3), dtype=bool), iterations=width, mask=~np.isfinite(depth))


def _said(
    pixels: Array, depths: Array, depth: NDArray[np.float32], arm: NDArray[np.bool_], same: float
) -> _Said:
    """What a picture says of known points; all is false where it looks through or has them not in view.

    Args:
        pixels: Of the points (u, v), shape (M, 2), in the picture `depth`.
        depths: Of the points [m], shape (M,).
        depth: Picture [m], shape (H, W).
        arm: Which of its pixels show the arm.
        same: By which depths differ that are of one place [m].
    """
    inside = ((pixels > -0.5) & (pixels < np.array(depth.shape[::-1]) - 0.5)).all(axis=-1)
    columns, rows = np.where(inside, np.round(pixels).T, 0).astype(int)
    nearer, covered = depths - depth[rows, columns], inside & arm[rows, columns]  # NaN without depth
    behind = inside & ~covered & (nearer > _BEHIND) & (nearer <= _ONE_BODY)
    there = inside & ~covered & (np.abs(nearer) <= same)
    return _Said(there, covered, behind, inside & ~covered & ~(nearer <= _ONE_BODY))
