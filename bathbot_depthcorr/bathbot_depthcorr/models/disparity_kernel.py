"""The per-pixel loops of the live correction, compiled: one pass over the image each, one thread.

They are written for the compiler to use the processor's vectors: no branch and no index but the column in
the innermost loop. Smooth maps are kept at every column but only at every few rows, and interpolated on the
way, so that memory carries hardly more than the image itself.
"""

import math

import numpy as np
from numba import njit

LEAST_DEPTH = 1e-3  # [m]; nearer is no depth
LEAST_SHARE = np.float32(0.05)  # of the disparity that a correction must leave

# All of LLVM's relaxed arithmetic but those that forget NaN, which means "no depth" here.
_RELAXED = {"contract", "reassoc", "arcp", "nsz"}
_SINE, _COSINE = (
    tuple(np.float32((-1) ** k * math.tau**order / math.factorial(order)) for k, order in enumerate(orders))
    for orders in ((1, 3, 5, 7), (0, 2, 4, 6, 8))
)
_ZERO, _QUARTER, _HALF, _ONE, _TWO = (np.float32(value) for value in (0.0, 0.25, 0.5, 1.0, 2.0))


@njit(fastmath=_RELAXED, inline="always")
def _ripple(disparity, amplitudes):
    """Ripple [px] at a disparity [px], from amplitudes of sin, cos (1 px) and sin, cos (1/2 px).

    Taylor's series about the quarter turn nearest by: right to 2e-4 of the amplitudes.
    """
    x = disparity - np.float32(np.int32(disparity + _HALF))
    y = _QUARTER - abs(x)
    square = y * y
    cosine = y * (_SINE[0] + square * (_SINE[1] + square * (_SINE[2] + square * _SINE[3])))
    sine = _COSINE[1] + square * (_COSINE[2] + square * (_COSINE[3] + square * _COSINE[4]))
    sine = _ONE + square * sine
    sine = -sine if x < _ZERO else sine
    twice = amplitudes[2] * _TWO * sine * cosine + amplitudes[3] * (_ONE - _TWO * sine * sine)
    return amplitudes[0] * sine + amplitudes[1] * cosine + twice


@njit(cache=True, nogil=True, fastmath=_RELAXED, error_model="numpy")
def correct_disparity(depth, scale, offset, step, focal_baseline, ripple, out):
    """Write z / (scale + (offset + ripple(d)) / d), d = f B / z, to `out`; NaN where there is no depth.

    Args:
        depth: Depth z [m], shape (H, W), float32, NaN = none.
        scale: 1 + s at every column of every `step`-th row, shape (R, W), float32.
        offset: o [px], likewise.
        step: Rows of the image between two rows of the maps.
        focal_baseline: f B [px m], float32.
        ripple: Amplitudes [px], shape (4,), float32.
        out: Where to write, shape (H, W), float32.
    """
    height, width = depth.shape
    least, none = np.float32(LEAST_DEPTH), np.float32(np.nan)
    for v in range(height):
        row = v // step
        t = np.float32(v - row * step) / np.float32(step)
        scale_0, scale_1, offset_0, offset_1 = scale[row], scale[row + 1], offset[row], offset[row + 1]
        source, target = depth[v], out[v]
        for u in range(width):
            known = source[u] >= least
            z = source[u] if known else _ONE
            disparity = focal_baseline / z
            bend = offset_0[u] + t * (offset_1[u] - offset_0[u]) + _ripple(disparity, ripple)
            below = scale_0[u] + t * (scale_1[u] - scale_0[u]) + bend * z / focal_baseline
            target[u] = z / below if known & (below > LEAST_SHARE) else none


@njit(cache=True, nogil=True, fastmath=_RELAXED, error_model="numpy")
def correct_two_imagers(depth, scale, left, right, step, focal_baseline, ripple, out):
    """Write z / (scale + (left(u) - right(u - d) + ripple(d)) / d) to `out`; as `correct_disparity`.

    Args:
        depth: Depth z [m], shape (H, W), float32, NaN = none.
        scale: 1 + s, float32.
        left: Map of the left imager [px] at every column of every `step`-th row, shape (R, W), float32.
        right: Of the right imager, likewise.
        step: Rows of the image between two rows of the maps.
        focal_baseline: f B [px m], float32.
        ripple: Amplitudes [px], shape (4,), float32.
        out: Where to write, shape (H, W), float32.
    """
    height, width = depth.shape
    least, none = np.float32(LEAST_DEPTH), np.float32(np.nan)
    last = np.float32(width - 2)
    matched, place = np.empty(width, np.float32), np.empty(width, np.float32)
    bend = np.empty(width, np.float32)
    for v in range(height):
        row = v // step
        t = np.float32(v - row * step) / np.float32(step)
        left_0, left_1, right_0, right_1 = left[row], left[row + 1], right[row], right[row + 1]
        source, target = depth[v], out[v]
        for u in range(width):
            z = source[u] if source[u] >= least else _ONE
            disparity = focal_baseline / z
            matched[u] = right_0[u] + t * (right_1[u] - right_0[u])
            x = np.float32(u) - disparity
            x = x if x > _ZERO else _ZERO
            place[u] = x if x < last else last
            bend[u] = left_0[u] + t * (left_1[u] - left_0[u]) + _ripple(disparity, ripple)
        for u in range(width):  # apart from the loops around it, as only this one cannot use vectors
            cell = np.uint32(place[u])
            bend[u] -= matched[cell] + (place[u] - np.float32(cell)) * (matched[cell + 1] - matched[cell])
        for u in range(width):
            known = source[u] >= least
            z = source[u] if known else _ONE
            below = scale + bend[u] * z / focal_baseline
            target[u] = z / below if known & (below > LEAST_SHARE) else none


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
