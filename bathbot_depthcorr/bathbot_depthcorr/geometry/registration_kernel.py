"""The loops of the registration, compiled: project depth pixels, then spread each over what it covers."""

import numpy as np
from numba import njit

_EDGE = np.float32(0.03)  # neighbours that differ by more than this share of depth are two surfaces
_OVERLAP = np.float32(0.55)  # half a pixel, and a little more so that no crack stays between neighbours
_NONE = np.float32(np.nan)


@njit(cache=True, nogil=True, error_model="numpy")
def project_window(depth, rays, origin, lens, span, places):
    """Write u, v [px] and inverse depth [1/m] in the colour camera to `places`; NaN where there is none.

    Args:
        depth: Depth [m], shape (h, w), float32, NaN = none.
        rays: Rays of the depth pixels turned to the colour frame, shape (3, h, w), float32.
        origin: Place of the depth camera in the colour frame [m], shape (3,), float32.
        lens: fx, fy, cx, cy, k1, k2, p1, p2, k3 of the colour camera, shape (9,), float32.
        span: Least and greatest depth [m] that counts, shape (2,), float32.
        places: Where to write, shape (3, h, w), float32.
    """
    fx, fy, cx, cy, k1, k2, p1, p2, k3 = lens
    ox, oy, oz = origin
    near, far = span
    one, two = np.float32(1.0), np.float32(2.0)
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            z = depth[i, j]
            away = rays[2, i, j] * z + oz
            x = (rays[0, i, j] * z + ox) / away
            y = (rays[1, i, j] * z + oy) / away
            r2 = x * x + y * y
            radial = one + r2 * (k1 + r2 * (k2 + r2 * k3))
            places[0, i, j] = fx * (x * radial + two * p1 * x * y + p2 * (r2 + two * x * x)) + cx
            places[1, i, j] = fy * (y * radial + p1 * (r2 + two * y * y) + two * p2 * x * y) + cy
            counts = (z >= near) & (z <= far) & (away > np.float32(0.01))
            places[2, i, j] = one / away if counts else _NONE


@njit(cache=True, nogil=True, error_model="numpy")
def _step(places, i, j, di, dj, nominal_u, nominal_v):
    """Change of (u, v, 1/depth) from one depth pixel to the next, over those neighbours on its surface."""
    count = np.float32(0.0)
    du, dv, dq = np.float32(0.0), np.float32(0.0), np.float32(0.0)
    q = places[2, i, j]
    for sign in (-1, 1):
        a, b = i + sign * di, j + sign * dj
        if 0 <= a < places.shape[1] and 0 <= b < places.shape[2]:
            step = (places[2, a, b] - q) * np.float32(sign)
            if abs(step) < _EDGE * q:  # false for NaN
                du += (places[0, a, b] - places[0, i, j]) * np.float32(sign)
                dv += (places[1, a, b] - places[1, i, j]) * np.float32(sign)
                dq += step
                count += np.float32(1.0)
    if count == 0.0:
        return nominal_u, nominal_v, np.float32(0.0)
    return du / count, dv / count, dq / count


@njit(cache=True, nogil=True, error_model="numpy")
def splat(depth, places, footprint, patch):
    """Give each depth pixel the parallelogram that reaches halfway to its neighbours; the nearest wins.

    Inverse depth is continued linearly over the parallelogram: that is what a plane's image does. A
    neighbour on another surface is not asked, so that nothing is drawn across an edge.

    Args:
        depth: Depth [m] that was projected, shape (h, w), float32.
        places: What `project_window` wrote, shape (3, h, w).
        footprint: Colour pixels per depth pixel along u and v, times Z_colour / Z_depth.
        patch: Holds inverse depth [1/m], float32; zero where there is none yet.
    """
    height, width = patch.shape
    for i in range(places.shape[1]):
        for j in range(places.shape[2]):
            u, v, q = places[0, i, j], places[1, i, j], places[2, i, j]
            if not (q > 0.0 and -4.0 < u < width + 3.0 and -4.0 < v < height + 3.0):
                continue
            zoom = depth[i, j] * q
            nothing = np.float32(0.0)
            au, av, aq = _step(places, i, j, 0, 1, footprint[0] * zoom, nothing)
            bu, bv, bq = _step(places, i, j, 1, 0, nothing, footprint[1] * zoom)
            area = au * bv - av * bu
            if not area > np.float32(1e-3):  # seen from behind or edge-on
                continue
            per_area = np.float32(1.0) / area
            half_u = _OVERLAP * (abs(au) + abs(bu))
            half_v = _OVERLAP * (abs(av) + abs(bv))
            for row in range(max(int(np.ceil(v - half_v)), 0), min(int(np.floor(v + half_v)) + 1, height)):
                for column in range(
                    max(int(np.ceil(u - half_u)), 0), min(int(np.floor(u + half_u)) + 1, width)
                ):
                    x, y = np.float32(column) - u, np.float32(row) - v
                    s = (x * bv - y * bu) * per_area
                    t = (y * au - x * av) * per_area
                    if abs(s) <= _OVERLAP and abs(t) <= _OVERLAP:
                        found = q + s * aq + t * bq
                        if found > patch[row, column]:
                            patch[row, column] = found
