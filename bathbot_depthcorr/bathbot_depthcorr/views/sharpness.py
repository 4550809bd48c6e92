"""How sharp a picture of the chessboard is: the width of the edges between its squares.

The edge between two neighbouring inner corners is straight and its ends are known, so the brightness across
its middle can be averaged over all edges of one direction. Motion blurs one direction more than the
other; the wider one counts.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.views.chessboard import Chessboard

Array = NDArray[np.float64]

MOST_EDGE_WIDTH = 4.0  # [px]: a sharp picture has 1.5 to 2.5
_STEP = 0.25  # [px] between samples across an edge
_ALONG = np.linspace(0.35, 0.65, 5)  # shares of an edge's length at which it is sampled


def edge_width(grey: NDArray, corners: Array, board: Chessboard) -> float:
    """Width [px] over which the board's edges go from black to white; infinite without contrast.

    Args:
        grey: Brightness, uint8, shape (H, W).
        corners: Inner corners [px], shape (N, 2), row by row.
        board: The board.
    """
    grid = corners.reshape(board.rows, board.columns, 2)
    across, along = grid[:, 1:] - grid[:, :-1], grid[1:] - grid[:-1]
    return max(
        _width(grey, grid[:, :-1].reshape(-1, 2), across.reshape(-1, 2)),
        _width(grey, grid[:-1].reshape(-1, 2), along.reshape(-1, 2)),
    )


def _width(grey: NDArray, starts: Array, edges: Array) -> float:
    """Contrast over steepest slope of the mean profile across edges, shape (M, 2) [px]."""
    lengths = np.linalg.norm(edges, axis=1)
    reach = max(2.0, 0.4 * float(lengths.min()))
    offsets = np.arange(-reach, reach + _STEP, _STEP)
    normals = np.stack([-edges[:, 1], edges[:, 0]], axis=1) / lengths[:, None]
    middles = starts[:, None] + edges[:, None] * _ALONG[:, None]
    points = (middles[:, :, None] + normals[:, None, None] * offsets[:, None]).astype(np.float32)
    flat = points.reshape(len(starts), -1, 2)
    seen = cv2.remap(grey, flat[..., 0], flat[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    profiles = seen.reshape(points.shape[:-1]).astype(float).mean(axis=1)
    rising = np.sign(profiles[:, -1] - profiles[:, 0])  # black and white change sides from edge to edge
    profile = (profiles * rising[:, None]).mean(axis=0)
    margin = len(offsets) // 8
    contrast = float(profile[-margin - 1 :].mean() - profile[: margin + 1].mean())
    slope = float(np.gradient(profile, _STEP).max())
    return contrast / slope if slope > 0.0 and contrast > 0.0 else float("inf")
