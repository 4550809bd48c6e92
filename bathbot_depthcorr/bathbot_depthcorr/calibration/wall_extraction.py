"""Takes what is not the wall out of a calibration view: bathtubs, floors, people, flying pixels.

Against the board's plane the raw wall is bent only smoothly. A robust quadratic over the image follows
that bend in disparity; pixels that lie off it are something else.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.views.views import CalibrationView, true_disparity

Array = NDArray[np.float64]

BAND = 5.0  # robust standard deviations about the smooth bend that count as wall,
NARROWEST, WIDEST = 0.2, 0.6  # within these limits [px] of disparity
_LEAST_SCALE = 0.05  # [px]
_EVERY = 6  # pixels between two samples of the robust fit


def only_wall(view: CalibrationView, unit: CameraUnit) -> CalibrationView:
    """The same view with NaN where the depth image shows anything but the wall.

    Args:
        view: Of the wall, seen with other things.
        unit: The camera, with the factory's depth -> colour transform.
    """
    camera = unit.depth_camera
    grid = camera.pixel_grid()
    bend = unit.focal_baseline / view.depth - true_disparity(view, unit, camera.directions(grid))
    u = (grid[..., 0] - 0.5 * camera.width) / camera.width
    v = (grid[..., 1] - 0.5 * camera.height) / camera.width
    terms = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=-1)
    sparse = (slice(None, None, _EVERY), slice(None, None, _EVERY))
    known = np.isfinite(bend[sparse])
    if np.count_nonzero(known) < 50:
        return view
    off = np.abs(bend - terms @ _robust(terms[sparse][known], bend[sparse][known]))
    band = np.clip(BAND * 1.4826 * np.nanmedian(off[sparse]), NARROWEST, WIDEST)
    depth = np.where(off <= band, view.depth, np.float32(np.nan))
    return replace(view, depth=depth.astype(np.float32))


def _robust(terms: Array, values: Array) -> Array:
    """Coefficients of a fit by Tukey's weights, begun at the median."""
    coefficients = np.zeros(terms.shape[1])
    coefficients[0] = np.median(values)
    for _ in range(20):
        left = values - terms @ coefficients
        scale = max(_LEAST_SCALE, 1.4826 * float(np.median(np.abs(left))))
        weight = np.square(np.clip(1.0 - np.square(left / (4.685 * scale)), 0.0, None))
        weighted = terms * weight[:, None]
        following = np.linalg.solve(
            weighted.T @ terms + 1e-9 * np.eye(len(coefficients)), weighted.T @ values
        )
        if np.abs(following - coefficients).max() < 1e-4:
            return following
        coefficients = following
    return coefficients
