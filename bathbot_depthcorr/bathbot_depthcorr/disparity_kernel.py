"""The per-pixel loops of the live correction, compiled: one pass over the image each, one thread."""

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def correct_disparity(depth, scale, offset, ripple, per_metre, out):
    """Write z / (scale + (offset + ripple(z)) z) to `out`; NaN where there is no depth.

    Args:
        depth: Depth z [m], shape (H, W), float32, NaN = none.
        scale: 1 + s, shape (H, W), float32.
        offset: o / (f B) [1/m], shape (H, W), float32.
        ripple: Ripple / (f B) [1/m] on a uniform grid of depth that starts at 0, shape (N,), float32.
        per_metre: Entries of `ripple` per metre.
        out: Where to write, shape (H, W), float32.
    """
    last = ripple.size - 2
    top = np.float32(last) / per_metre
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            z = depth[v, u]
            if not z > 0.0:
                out[v, u] = np.nan
                continue
            place = min(z, top) * per_metre
            index = min(int(place), last)
            low = ripple[index]
            bend = low + (ripple[index + 1] - low) * (place - np.float32(index))
            below = scale[v, u] + (offset[v, u] + bend) * z
            out[v, u] = z / below if below > np.float32(0.05) else np.nan


@njit(cache=True, nogil=True)
def correct_polynomial(depth, local, overall, near, far, out):
    """Write f_g(f_i(z)) to `out`; outside [near, far] the polynomials continue with slope one.

    Args:
        depth: Depth z [m], shape (H, W), float32, NaN = none.
        local: Coefficients of f_i, lowest first, shape (H, W, 3), float32.
        overall: Coefficients of f_g, lowest first, shape (3,), float32.
        near: Least depth of the fit [m].
        far: Greatest depth of the fit [m].
        out: Where to write, shape (H, W), float32.
    """
    for v in range(depth.shape[0]):
        for u in range(depth.shape[1]):
            z = depth[v, u]
            if not z > 0.0:
                out[v, u] = np.nan
                continue
            inside = min(max(z, near), far)
            flat = local[v, u, 0] + inside * (local[v, u, 1] + inside * local[v, u, 2])
            value = overall[0] + flat * (overall[1] + flat * overall[2]) + (z - inside)
            out[v, u] = value if value > 0.0 else np.nan
