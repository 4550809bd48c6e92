"""Average a surface over neighbouring pixels without bending it.

The mean of inverse depth over a window centred on a pixel is exact on a plane, and stereo noise is
uniform in inverse depth. At a hole the window would lose its balance and a sloping surface would
shift, so a pixel counts only together with its mirror image through the centre.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
_STEP = 0.02  # [m] neighbours that differ more in depth belong to another surface


def smooth_inverse_depth(points_camera: Array, window: int) -> Array:
    """Points with averaged depth along their own rays, shape (h, w, 3); NaN stays NaN.

    Args:
        points_camera: Camera frame [m], shape (h, w, 3).
        window: Points per side of the square window, odd.
    """
    depth = np.ascontiguousarray(points_camera[..., 2])
    with np.errstate(invalid="ignore"):
        return points_camera / depth[..., None] * _mean_depth(depth, window // 2)[..., None]


@njit(cache=True, nogil=True)
def _mean_depth(depth, reach):
    """Depth of the mean inverse depth over balanced pairs of neighbours."""
    height, width = depth.shape
    mean = np.full_like(depth, np.nan)
    for v in range(height):
        for u in range(width):
            centre = depth[v, u]
            if not centre > 0.0:
                continue
            total, count = 1.0 / centre, 1
            for dv in range(0, reach + 1):
                for du in range(-reach if dv > 0 else 1, reach + 1):
                    if not (dv <= v < height - dv and abs(du) <= u < width - abs(du)):
                        continue
                    one, other = depth[v + dv, u + du], depth[v - dv, u - du]
                    if (
                        abs(one + other - 2.0 * centre) < 2.0 * _STEP
                        and abs(one - other) < 4.0 * _STEP * reach
                    ):
                        total += 1.0 / one + 1.0 / other
                        count += 2
            mean[v, u] = count / total
    return mean
