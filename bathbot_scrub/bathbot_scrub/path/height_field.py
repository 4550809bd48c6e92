"""A smooth skin surface from noisy cells: local quadratic regression on a grid.

Depth noise is about 1 mm per pixel and lumps over some pixels. Each grid node takes the value of a
quadratic fitted to the cells around it with Gaussian weights: a plain mean would sink a curved limb
by sigma^2/R. The sums of the normal equations are separable correlations, so a patch costs a few ms.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage
from scipy.interpolate import RectBivariateSpline

from bathbot_scrub.path.patch import Cells, Mask, PatchGrid
from bathbot_scrub.path.triangle_normals import triangle_normals

Array = NDArray[np.float64]
_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))  # exponents of x and y of the quadratic
_CIRCLE = 8  # points of a circle at which relief is looked for
_RIDGE = 1e-6  # keeps the fit solvable where a node sees a handful of cells


def smooth(cells: Cells, sigma: float) -> Array:
    """Fit a quadratic around each node and take its value there.

    Args:
        cells: Heights [m] and point counts, shapes (rows, columns).
        sigma: Width of the Gaussian weight [cells].

    Returns:
        Heights [m], shape (rows, columns); NaN where fewer than six cells are in sight.
    """
    weight = np.where(np.isfinite(cells.height), cells.count, 0.0)
    height = np.nan_to_num(cells.height)
    offset = np.average(height, weights=weight) if weight.any() else 0.0
    radius = int(np.ceil(2.5 * sigma))
    arm = np.arange(-radius, radius + 1) / sigma
    bell = np.exp(-0.5 * arm**2)
    kernels = [bell * arm**power for power in range(5)]
    along_x = [ndimage.correlate1d(weight, kernel, axis=1, mode="constant") for kernel in kernels]
    moments = {
        (i, j): ndimage.correlate1d(along_x[i], kernels[j], axis=0, mode="constant")
        for i in range(5)
        for j in range(5 - i)
    }
    lifted = weight * (height - offset)
    raised = [ndimage.correlate1d(lifted, kernel, axis=1, mode="constant") for kernel in kernels[:3]]
    right = np.stack(
        [ndimage.correlate1d(raised[i], kernels[j], axis=0, mode="constant") for i, j in _POWERS], axis=-1
    )
    rows = [np.stack([moments[i + k, j + m] for k, m in _POWERS], axis=-1) for i, j in _POWERS]
    normal = np.stack(rows, axis=-2)
    seen = ndimage.uniform_filter((weight > 0.0).astype(float), 2 * radius + 1, mode="constant")
    usable = seen * (2 * radius + 1) ** 2 > len(_POWERS) - 0.5
    scale = np.maximum(moments[0, 0], 1e-12)[..., None]
    system = normal / scale[..., None] + _RIDGE * np.eye(len(_POWERS))
    fitted = np.full(weight.shape, np.nan)
    solution = np.linalg.solve(system[usable], (right / scale)[usable][..., None])
    fitted[usable] = solution[:, 0, 0] + offset
    return fitted


class HeightField:
    """A smooth surface over a patch grid, with its normals by Fig. 6 and Eqs. (11)-(13)."""

    def __init__(self, grid: PatchGrid, height: ArrayLike, valid: Mask) -> None:
        """Keep heights [m] on the nodes of `grid` and which of them are skin, shapes (rows, columns)."""
        self.grid = grid
        self.height = np.asarray(height, dtype=float)
        self.valid = valid & np.isfinite(self.height)

    @cached_property
    def slope(self) -> Array:
        """Rise along x and along y at the nodes, shape (rows, columns, 2)."""
        along_y, along_x = np.gradient(_filled(self.height, self.valid), self.grid.cell)
        return np.stack([along_x, along_y], axis=-1)

    def transposed(self) -> "HeightField":
        """The same surface with x and y exchanged (which mirrors it)."""
        grid = replace(self.grid, half_length=self.grid.half_width, half_width=self.grid.half_length)
        return HeightField(grid, self.height.T, self.valid.T)

    @cached_property
    def _spline(self) -> RectBivariateSpline:
        return RectBivariateSpline(self.grid.y, self.grid.x, _filled(self.height, self.valid), kx=3, ky=3)

    @cached_property
    def normals(self) -> Array:
        """Outward unit normals at the nodes, patch frame, shape (rows, columns, 3); NaN off the skin."""
        x, y = np.meshgrid(self.grid.x, self.grid.y)
        points = np.stack([x, y, np.where(self.valid, self.height, np.nan)], axis=-1)
        return triangle_normals(points, (0.0, 0.0, 1.0))

    @cached_property
    def _normal_parts(self) -> list[Array]:
        normals = self.normals
        return [_filled(normals[..., axis], np.isfinite(normals[..., axis])) for axis in range(3)]

    def points_at(self, plane: ArrayLike) -> Array:
        """Points of the skin above plane positions (x, y) [m], shape (N, 2) -> (N, 3), patch frame."""
        plane = np.asarray(plane, dtype=float)
        return np.column_stack([plane, self._spline.ev(plane[:, 1], plane[:, 0])])

    def normals_at(self, plane: ArrayLike) -> Array:
        """Outward unit normals above plane positions (x, y) [m], shape (N, 2) -> (N, 3), patch frame."""
        plane = np.asarray(plane, dtype=float)
        index = self._index(plane)
        mixed = np.stack(
            [ndimage.map_coordinates(part, index, order=1, mode="nearest") for part in self._normal_parts],
            axis=-1,
        )
        return mixed / np.linalg.norm(mixed, axis=-1, keepdims=True)

    def relief_at(self, plane: ArrayLike, radius: float) -> Array:
        """How high the skin rises over its tangent plane on a circle around positions (x, y) [m].

        Args:
            plane: Positions, shape (N, 2).
            radius: Of the circle, in the plane of the patch [m].

        Returns:
            The most on the circle, shape (N,); negative where the skin falls off on all sides.
        """
        plane = np.asarray(plane, dtype=float)
        angles = np.arange(_CIRCLE) * 2.0 * np.pi / _CIRCLE
        circle = radius * np.column_stack([np.cos(angles), np.sin(angles)])
        around = self.points_at((plane[:, None] + circle).reshape(-1, 2)).reshape(-1, _CIRCLE, 3)
        offsets = around - self.points_at(plane)[:, None]
        return np.einsum("nkc,nc->nk", offsets, self.normals_at(plane)).max(axis=1)

    def _index(self, plane: Array) -> Array:
        """Fractional (row, column) of plane positions, shape (N, 2) -> (2, N)."""
        rows, columns = self.height.shape
        steps = plane / self.grid.cell
        return np.stack([steps[:, 1] + rows // 2, steps[:, 0] + columns // 2])


def _filled(values: Array, known: Mask) -> Array:
    """Values with each unknown one replaced by its nearest known neighbour, shape (rows, columns)."""
    if known.all() or not known.any():
        return np.where(known, values, 0.0)
    nearest = ndimage.distance_transform_edt(~known, return_distances=False, return_indices=True)
    return values[tuple(nearest)]
