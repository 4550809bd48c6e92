"""Tensor-product cubic B-splines over the image: smooth maps with few coefficients."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class SplineGrid:
    """Uniform cubic B-splines: `columns` x `rows` coefficients over an image of `width` x `height` px."""

    width: int
    height: int
    columns: int
    rows: int

    @property
    def count(self) -> int:
        """Number of coefficients."""
        return self.columns * self.rows

    def basis(self, u: ArrayLike, v: ArrayLike) -> tuple[Array, Array]:
        """Bases along u, shape (len(u), columns), and v, shape (len(v), rows), at pixels of a grid."""
        return _axis_basis(u, self.width, self.columns), _axis_basis(v, self.height, self.rows)

    def local(self, pixels: ArrayLike) -> tuple[NDArray[np.intp], Array]:
        """The 16 coefficients that matter at each pixel: ascending indices, and bases, shape (N, 16) each.

        Args:
            pixels: (u, v) inside the image, shape (N, 2).
        """
        pixels = np.asarray(pixels, dtype=float)
        columns, along_u = _local_basis(pixels[:, 0], self.width, self.columns)
        rows, along_v = _local_basis(pixels[:, 1], self.height, self.rows)
        index = rows[:, :, None] * self.columns + columns[:, None, :]
        return index.reshape(-1, 16), (along_v[:, :, None] * along_u[:, None, :]).reshape(-1, 16)

    def evaluate(self, coefficients: ArrayLike, u: ArrayLike, v: ArrayLike) -> Array:
        """Surface, shape (len(v), len(u)), of coefficients, shape (count,), v slowest."""
        along_u, along_v = self.basis(u, v)
        return along_v @ np.asarray(coefficients).reshape(self.rows, self.columns) @ along_u.T

    def full(self, coefficients: ArrayLike) -> Array:
        """Surface at every pixel, shape (height, width)."""
        return self.evaluate(coefficients, np.arange(self.width), np.arange(self.height))

    def sparse_rows(self, coefficients: ArrayLike, step: int) -> NDArray[np.float32]:
        """Surface at every column of rows 0, step, 2 step ... one row beyond the image."""
        v = step * np.arange((self.height - 1) // step + 2)
        return self.evaluate(coefficients, np.arange(self.width), v).astype(np.float32)

    def roughness(self) -> Array:
        """Quadratic form, shape (count, count): the sum of squared second differences of coefficients."""
        columns, rows = np.eye(self.columns), np.eye(self.rows)
        along_u = np.kron(rows, np.diff(columns, 2, axis=0))
        along_v = np.kron(np.diff(rows, 2, axis=0), columns)
        return along_u.T @ along_u + along_v.T @ along_v


def row_step(height: int) -> int:
    """Rows between which a smooth map may be interpolated: a ninetieth of the image, at least 1."""
    return max(1, height // 90)


def _design(pixels: ArrayLike, size: int, count: int) -> csr_array:
    step = size / (count - 3)
    knots = -0.5 + step * np.arange(-3, count + 1)
    return BSpline.design_matrix(np.asarray(pixels, dtype=float), knots, 3, extrapolate=True)


def _axis_basis(pixels: ArrayLike, size: int, count: int) -> Array:
    return _design(pixels, size, count).toarray()


def _local_basis(pixels: ArrayLike, size: int, count: int) -> tuple[NDArray[np.intp], Array]:
    design = _design(pixels, size, count)
    return design.indices.reshape(-1, 4), design.data.reshape(-1, 4)
