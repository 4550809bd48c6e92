"""The patch of skin around a contact target, as a grid in the target's tangent plane.

Patch frame: origin at the target, x = the target's direction of travel, z = out of the skin,
y = z x x. In it the skin is a height field h(x, y), known in square cells. Pixels enter it only if
they hang together with the target's pixel without a jump in depth: a hand before the belly, the
chair and the background stay out.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse, transform_from, transform_points
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from bathbot_scrub.errors import SurfaceError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Index = NDArray[np.int_]


class Cells(NamedTuple):
    """Heights of a surface over the cells of a grid.

    Attributes:
        height: Mean height of the points in a cell [m], shape (rows, columns); NaN where none.
        count: Number of points in a cell, shape (rows, columns).
    """

    height: Array
    count: Array


class PixelBox(NamedTuple):
    """Part of an image, rows and columns from (included) to (excluded)."""

    top: int
    bottom: int
    left: int
    right: int

    def crop(self, image: Array) -> Array:
        """The part of an image, shape (H, W, ...), inside the box."""
        return image[self.top : self.bottom, self.left : self.right]


@dataclass(frozen=True, slots=True)
class PatchGrid:
    """Square cells around a target, rows along y, columns along x of the patch frame.

    Attributes:
        T_base_patch: Pose of the patch frame in the base frame, shape (4, 4).
        half_length: Half the extent along x [m].
        half_width: Half the extent along y [m].
        cell: Side of a cell [m].
    """

    T_base_patch: Array
    half_length: float
    half_width: float
    cell: float

    @property
    def x(self) -> Array:
        """Centres of the columns [m], shape (columns,); the target lies on one."""
        count = round(self.half_length / self.cell)
        return np.arange(-count, count + 1) * self.cell

    @property
    def y(self) -> Array:
        """Centres of the rows [m], shape (rows,); the target lies on one."""
        count = round(self.half_width / self.cell)
        return np.arange(-count, count + 1) * self.cell

    @property
    def outward(self) -> Array:
        """Outward normal at the target in the base frame, shape (3,)."""
        return self.T_base_patch[:3, 2]

    def to_patch(self, points_base: ArrayLike) -> Array:
        """Points of the base frame in the patch frame [m], shape (..., 3)."""
        return transform_points(inverse(self.T_base_patch), points_base)

    def to_base(self, points_patch: ArrayLike) -> Array:
        """Points of the patch frame in the base frame [m], shape (..., 3)."""
        return transform_points(self.T_base_patch, points_patch)

    def cells_of(self, plane: ArrayLike) -> tuple[Index, Index, Mask]:
        """Cells under positions (x, y) [m], shape (N, 2): rows, columns, and which of them exist, (N,)."""
        plane = np.asarray(plane, dtype=float)
        rows, columns = len(self.y), len(self.x)
        column = np.rint(plane[:, 0] / self.cell).astype(int) + columns // 2
        row = np.rint(plane[:, 1] / self.cell).astype(int) + rows // 2
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        return np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1), inside

    def bin(self, points_patch: ArrayLike, slope: Array | None = None) -> Cells:
        """Sort points into the cells; those outside are left out.

        Args:
            points_patch: Points of the patch frame [m], shape (N, 3), finite.
            slope: Rise of the surface along x and y in each cell, shape (rows, columns, 2), along which
                heights are carried to the middle of the cell; nothing: not at all.
        """
        points = np.asarray(points_patch, dtype=float)
        row, column, inside = self.cells_of(points[:, :2])
        row, column, points = row[inside], column[inside], points[inside]
        height = points[:, 2]
        if slope is not None:
            off_middle = points[:, :2] - np.column_stack([self.x[column], self.y[row]])
            height = height - np.sum(slope[row, column] * off_middle, axis=1)
        shape = len(self.y), len(self.x)
        index, size = row * shape[1] + column, shape[0] * shape[1]
        count = np.bincount(index, minlength=size).astype(float)
        total = np.bincount(index, height, minlength=size).astype(float)
        mean = np.divide(total, count, out=np.full(size, np.nan), where=count > 0.0)
        return Cells(mean.reshape(shape), count.reshape(shape))


def patch_frame(T_base_target: ArrayLike) -> Array:
    """Pose of the patch frame, shape (4, 4), of a head pose on the skin (z into it, y along travel)."""
    target = np.asarray(T_base_target, dtype=float)
    x, z = target[:3, 1], -target[:3, 2]
    return transform_from(np.stack([x, np.cross(z, x), z], axis=-1), target[:3, 3])


def around(surface_patch: Array, reach: float, depth: float) -> PixelBox:
    """The smallest box of pixels that holds all points near the target.

    Args:
        surface_patch: Organised points in the patch frame [m], shape (H, W, 3), NaN where unknown.
        reach: How far sideways a point counts as near [m].
        depth: How far along the normal [m].

    Raises:
        SurfaceError: When there is none.
    """
    near = np.all(np.abs(surface_patch) < (reach, reach, depth), axis=-1)
    rows, columns = np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))
    if not len(rows):
        raise SurfaceError(
            f"none of {near.size} surface points lies within {reach} m of the contact target; "
            "is the surface of the chosen region published, and is the hand-eye calibration the right one?"
        )
    return PixelBox(int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1)


def connected_skin(surface_patch: Array, jump: float, reach: float) -> Mask:
    """Pixels that hang together with the target without a jump in height.

    Args:
        surface_patch: Organised points in the patch frame [m], shape (H, W, 3), NaN where unknown.
        jump: Height step between neighbouring pixels that ends the skin [m].
        reach: Distance from the target within which its pixel must lie [m].

    Returns:
        Mask of the pixels, shape (H, W).

    Raises:
        SurfaceError: When no skin is seen at the target.
    """
    height = surface_patch[..., 2]
    known = np.isfinite(height)
    with np.errstate(invalid="ignore"):
        torn_down = np.abs(np.diff(height, axis=0)) > jump
        torn_right = np.abs(np.diff(height, axis=1)) > jump
    whole = known.copy()
    whole[:-1] &= ~torn_down
    whole[1:] &= ~torn_down
    whole[:, :-1] &= ~torn_right
    whole[:, 1:] &= ~torn_right
    distance = np.where(whole, np.linalg.norm(np.nan_to_num(surface_patch), axis=-1), np.inf)
    nearest = np.unravel_index(np.argmin(distance), distance.shape)
    if not distance[nearest] < reach:
        raise SurfaceError(
            f"no skin within {reach * 1000.0:.0f} mm of the contact target, the nearest lies "
            f"{distance[nearest] * 1000.0:.0f} mm away; ask for a newer contact target"
        )
    labels, _ = ndimage.label(whole)
    return labels == labels[nearest]
