"""The compiled loop of `registration`: triangles between depth pixels, drawn with a z-buffer."""

import numpy as np
from numba import njit

EDGE = 0.06  # greatest step of depth inside a triangle, relative to its depth


@njit(cache=True, nogil=True)
def draw(depth, part, rays, transform, intrinsics, distortion, widest, corner, stride, buffer):
    """Draw a part of a depth picture into a grid of pixels of another camera.

    Args:
        depth: Depth [m], shape (H, W), NaN = none.
        part: Its part to draw, (left, top, right, bottom) [px].
        rays: Rays (x/z, y/z, 1) of the depth pixels, shape (H, W, 3).
        transform: Depth camera to other camera, shape (4, 4).
        intrinsics: (fx, fy, cx, cy) of the other camera [px].
        distortion: Its (k1, k2, p1, p2, k3).
        widest: Distance from the axis, as tangent, at which its lens model ends.
        corner: Pixel (u, v) of the grid's first point.
        stride: Pixels between points of the grid.
        buffer: Inverse depth [1/m] in the other camera, shape (h, w), 0 = none; updated in place.
    """
    height, width = part[3] - part[1], part[2] - part[0]
    place = np.full((2, max(width, 1), 3), np.nan)  # (u, v, 1/Z) in the grid, this row and the one before
    for j in range(height):
        now, before = j % 2, (j + 1) % 2
        for i in range(width):
            z, ray = depth[part[1] + j, part[0] + i], rays[part[1] + j, part[0] + i]
            place[now, i] = _place(z * ray[0], z * ray[1], z, transform, intrinsics, distortion, widest)
            place[now, i, 0] = (place[now, i, 0] - corner[0]) / stride
            place[now, i, 1] = (place[now, i, 1] - corner[1]) / stride
        for i in range(width - 1 if j > 0 else 0):
            au, av, aw = place[before, i]
            bu, bv, bw = place[before, i + 1]
            cu, cv, cw = place[now, i]
            du, dv, dw = place[now, i + 1]
            # With one pixel of four missing the other three still span a triangle.
            if aw == aw and dw == dw:
                _triangle(au, av, aw, du, dv, dw, bu, bv, bw, buffer)
                _triangle(au, av, aw, du, dv, dw, cu, cv, cw, buffer)
            else:
                _triangle(bu, bv, bw, cu, cv, cw, au, av, aw, buffer)
                _triangle(bu, bv, bw, cu, cv, cw, du, dv, dw, buffer)


@njit(cache=True, nogil=True)
def _place(x, y, z, transform, intrinsics, distortion, widest):
    """Pixel and inverse depth (u, v, 1/Z) of a point; NaN without depth or out of the camera's view."""
    depth = transform[2, 0] * x + transform[2, 1] * y + transform[2, 2] * z + transform[2, 3]
    if not (z > 0.0 and depth > 0.0):
        return np.nan, np.nan, np.nan
    px = (transform[0, 0] * x + transform[0, 1] * y + transform[0, 2] * z + transform[0, 3]) / depth
    py = (transform[1, 0] * x + transform[1, 1] * y + transform[1, 2] * z + transform[1, 3]) / depth
    k1, k2, p1, p2, k3 = distortion[0], distortion[1], distortion[2], distortion[3], distortion[4]
    r2 = px * px + py * py
    if r2 > widest * widest:
        return np.nan, np.nan, np.nan
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    u = px * radial + 2.0 * p1 * px * py + p2 * (r2 + 2.0 * px * px)
    v = py * radial + p1 * (r2 + 2.0 * py * py) + 2.0 * p2 * px * py
    return u * intrinsics[0] + intrinsics[2], v * intrinsics[1] + intrinsics[3], 1.0 / depth


@njit(cache=True, nogil=True)
def _triangle(au, av, aw, bu, bv, bw, cu, cv, cw, buffer):
    """Set the points of the grid inside one triangle where it is nearer than what is there."""
    if not aw + bw + cw > 0.0:
        return  # a corner without depth
    first_u = max(int(np.ceil(min(au, bu, cu) - 1e-9)), 0)
    last_u = min(int(np.floor(max(au, bu, cu) + 1e-9)), buffer.shape[1] - 1)
    if first_u > last_u:
        return
    first_v = max(int(np.ceil(min(av, bv, cv) - 1e-9)), 0)
    last_v = min(int(np.floor(max(av, bv, cv) + 1e-9)), buffer.shape[0] - 1)
    area = (bu - au) * (cv - av) - (cu - au) * (bv - av)
    if first_v > last_v or abs(area) < 1e-12:
        return
    highest = max(aw, bw, cw)
    if highest - min(aw, bw, cw) > EDGE * highest:
        return
    for v in range(first_v, last_v + 1):
        for u in range(first_u, last_u + 1):
            s = ((u - au) * (cv - av) - (cu - au) * (v - av)) / area
            t = ((bu - au) * (v - av) - (u - au) * (bv - av)) / area
            if s >= -1e-9 and t >= -1e-9 and s + t <= 1.0 + 1e-9:
                inverse_depth = aw + s * (bw - aw) + t * (cw - aw)
                if inverse_depth > buffer[v, u]:
                    buffer[v, u] = inverse_depth
