"""Which triangle a pixel sees, how far away, and where on it: a z-buffer.

Triangles are small (skin about 12 mm), so a distorted camera needs no more than distorted corners.
"""

from typing import NamedTuple

import numba
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from numpy.typing import ArrayLike, NDArray

NEAR = 0.03  # [m]; triangles nearer than this are not drawn


class Fragments(NamedTuple):
    """What each pixel sees.

    Attributes:
        depth: Distance along the optical axis [m], of what lay behind where no triangle is, shape (H, W)
            float32.
        face: Triangle number, -1 where none, shape (H, W) int32.
        weights: Barycentric weights of the triangle's corners, shape (H, W, 3) float32.
    """

    depth: NDArray[np.float32]
    face: NDArray[np.int32]
    weights: NDArray[np.float32]


@numba.njit(cache=True, nogil=True)
def _fill(u, v, z, faces, depth, face, weights):
    height, width = depth.shape
    for k in range(faces.shape[0]):
        a, b, c = faces[k, 0], faces[k, 1], faces[k, 2]
        za, zb, zc = z[a], z[b], z[c]
        if not (za > NEAR and zb > NEAR and zc > NEAR):
            continue
        ua, va, ub, vb, uc, vc = u[a], v[a], u[b], v[b], u[c], v[c]
        area = (ub - ua) * (vc - va) - (uc - ua) * (vb - va)
        if area >= 0.0:  # image v points down: counter-clockwise from outside is negative
            continue
        left, right = max(int(np.ceil(min(ua, ub, uc))), 0), min(int(np.floor(max(ua, ub, uc))), width - 1)
        top, bottom = max(int(np.ceil(min(va, vb, vc))), 0), min(int(np.floor(max(va, vb, vc))), height - 1)
        ia, ib, ic = 1.0 / za, 1.0 / zb, 1.0 / zc
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                wa = ((ub - x) * (vc - y) - (uc - x) * (vb - y)) / area
                wb = ((uc - x) * (va - y) - (ua - x) * (vc - y)) / area
                wc = 1.0 - wa - wb
                if wa < 0.0 or wb < 0.0 or wc < 0.0:
                    continue
                near = wa * ia + wb * ib + wc * ic
                if 1.0 / near < depth[y, x]:
                    depth[y, x] = 1.0 / near
                    face[y, x] = k
                    weights[y, x, 0] = wa * ia / near
                    weights[y, x, 1] = wb * ib / near
                    weights[y, x, 2] = wc * ic / near


def project_vertices(
    vertices_world: ArrayLike, pinhole: Pinhole, T_world_camera: ArrayLike
) -> NDArray[np.float32]:
    """Pixels and depth (u, v, z) of points [m], shape (V, 3); z is NaN behind the camera."""
    points = transform_points(inverse(T_world_camera), vertices_world)
    # Far outside the picture the distortion polynomial folds back: such points must not be drawn.
    wide = np.hypot(points[:, 0], points[:, 1]) > 1.8 * np.abs(points[:, 2])
    points[(points[:, 2] <= NEAR) | wide] = np.nan
    with np.errstate(invalid="ignore"):
        return np.concatenate([pinhole.project(points), points[:, 2:]], axis=1).astype(np.float32)


def rasterise(
    projected: NDArray[np.float32], faces: NDArray[np.int32], behind: NDArray[np.float32]
) -> Fragments:
    """Draw triangles, seen from outside only, into a picture.

    Args:
        projected: Pixels and depth (u, v, z) of the vertices, shape (V, 3).
        faces: Corners, shape (F, 3).
        behind: Distance of what the picture shows already [m], inf where nothing, shape (H, W).
    """
    fragments = Fragments(
        behind.copy(),
        np.full(behind.shape, -1, dtype=np.int32),
        np.zeros((*behind.shape, 3), dtype=np.float32),
    )
    u, v, z = (np.ascontiguousarray(column) for column in projected.T)
    _fill(u, v, z, faces, *fragments)
    return fragments
