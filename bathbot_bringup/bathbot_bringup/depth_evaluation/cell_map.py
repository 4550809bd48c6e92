"""Maps with one value per cell; a cell is a block of `bathbot_depthcorr.views.block_size`."""

import cv2
import numpy as np
from bathbot_depthcorr.camera_unit import CameraUnit
from bathbot_depthcorr.views import block_centres
from numpy.typing import NDArray


def cell_shape(unit: CameraUnit) -> tuple[int, int]:
    """Rows and columns of the cells."""
    u, v = block_centres(unit.depth_camera)
    return len(v), len(u)


def spread_cells(values: NDArray, unit: CameraUnit) -> NDArray[np.float32]:
    """Values at the centres of cells, shape (rows, columns, ...), bilinear at each pixel, (H, W, ...)."""
    size = (unit.depth_camera.width, unit.depth_camera.height)
    resized = cv2.resize(np.asarray(values, dtype=np.float32), size, interpolation=cv2.INTER_LINEAR)
    return np.ascontiguousarray(resized)
