"""Calibration views as every baseline takes them: means of disparity over the blocks of the image."""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from bathbot_depthcorr.correction_model import CameraUnit
from bathbot_depthcorr.views import CalibrationView, block_means, block_size
from numpy.typing import NDArray

Array = NDArray[np.float64]
Depth = NDArray[np.float32]


class WallCells(NamedTuple):
    """One view, cell by cell (a cell is a block of `views.block_size`); NaN where a cell saw too little.

    Attributes:
        disparity: Mean raw disparity f B / Z [px], shape (rows, columns).
        pixels: Mean (u, v) of the cell's valid pixels, shape (rows, columns, 2).
        directions: Ray (x/z, y/z, 1) through `pixels`, shape (rows, columns, 3).
        plane: m of the wall in the colour frame (m.x = 1) [1/m], shape (3,).
        information: Inverse covariance of m [m^2], shape (3, 3).
    """

    disparity: Array
    pixels: Array
    directions: Array
    plane: Array
    information: Array


def wall_cells(views: Sequence[CalibrationView], unit: CameraUnit) -> list[WallCells]:
    """Means over the cells of each view; disparity is averaged, as its noise does not depend on distance."""
    camera, size = unit.depth_camera, block_size(unit.depth_camera)
    grid = camera.pixel_grid()
    walls = []
    for view in views:
        valid = view.depth > 0.0
        disparity = unit.focal_baseline / np.where(valid, view.depth, 1.0)
        u, v = (block_means(grid[..., axis], valid, size) for axis in (0, 1))
        pixels = np.stack([u, v], axis=-1)
        information = np.linalg.inv(view.covariance + np.eye(3) * 1e-12)
        means = block_means(disparity, valid, size)
        walls.append(
            WallCells(means, pixels, camera.directions(pixels), view.plane.inverse_form, information)
        )
    return walls


def spread_cells(values: Array, unit: CameraUnit) -> Depth:
    """Values at the centres of cells, shape (rows, columns, ...), bilinear at each pixel, (H, W, ...)."""
    camera = unit.depth_camera
    resized = cv2.resize(
        np.asarray(values, dtype=np.float32), (camera.width, camera.height), interpolation=cv2.INTER_LINEAR
    )
    return np.ascontiguousarray(resized)


def positive(depth: Depth) -> Depth:
    """Depth as float32, NaN where it is not positive."""
    return np.where(depth > 0.0, depth, np.nan).astype(np.float32)
