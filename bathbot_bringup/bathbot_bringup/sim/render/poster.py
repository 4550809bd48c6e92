"""Flat printed targets drawn exactly: rays meet the plane, and a pixel averages many of them.

Corner finders notice errors of a hundredth of a pixel, so a texture's cells have sharp edges and the lens's
blur is the pixel's own area.
"""

from dataclasses import dataclass

import numba
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, rotate, transform_points
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.render.render import camera_rays

SAMPLES = 4  # per pixel and direction


@dataclass(frozen=True, slots=True)
class Poster:
    """A printed rectangle; in its frame x is right, y down as printed, z into the wall, 0 the centre.

    Attributes:
        width: [m].
        height: [m].
        cells: Reflectance 0..1 of its cells, row 0 at the top, shape (rows, columns).
    """

    width: float
    height: float
    cells: NDArray[np.float32]


@numba.njit(cache=True, nogil=True)
def _draw(rays, across, down, eye, half_w, half_h, cells, light, radiance, depth):
    rows, columns = cells.shape
    for v in range(rays.shape[0]):
        for u in range(rays.shape[1]):
            towards = rays[v, u, 2]
            if towards <= 1e-9 or -eye[2] / towards > depth[v, u] + 1e-6:
                continue
            x, y = eye[0] - eye[2] / towards * rays[v, u, 0], eye[1] - eye[2] / towards * rays[v, u, 1]
            if abs(x) > half_w + 0.02 or abs(y) > half_h + 0.02:
                continue
            inside, total = 0, 0.0
            for j in range(SAMPLES):
                for i in range(SAMPLES):
                    a, b = (i + 0.5) / SAMPLES - 0.5, (j + 0.5) / SAMPLES - 0.5
                    z = rays[v, u, 2] + a * across[v, u, 2] + b * down[v, u, 2]
                    x = eye[0] - eye[2] / z * (rays[v, u, 0] + a * across[v, u, 0] + b * down[v, u, 0])
                    y = eye[1] - eye[2] / z * (rays[v, u, 1] + a * across[v, u, 1] + b * down[v, u, 1])
                    if abs(x) < half_w and abs(y) < half_h:
                        inside += 1
                        total += cells[
                            int((y + half_h) / (2 * half_h) * rows),
                            int((x + half_w) / (2 * half_w) * columns),
                        ]
            share = inside / (SAMPLES * SAMPLES)
            for c in range(3):
                radiance[v, u, c] = (1.0 - share) * radiance[v, u, c] + light[c] * total / (SAMPLES * SAMPLES)
            if 2 * inside > SAMPLES * SAMPLES:
                depth[v, u] = -eye[2] / towards


def draw_poster(
    poster: Poster, T_world_poster: ArrayLike, pinhole: Pinhole, T_world_camera: ArrayLike, light: ArrayLike,
    radiance: NDArray[np.float32], depth: NDArray[np.float32],
) -> None:  # fmt: skip
    """Draw a poster into a picture where it is nearer than what the picture shows.

    Args:
        poster: What is printed.
        T_world_poster: Where it hangs.
        pinhole: The camera.
        T_world_camera: Where the camera is.
        light: Linear light on it, shape (3,).
        radiance: Linear light of the picture, shape (H, W, 3); changed.
        depth: Distance [m] along the axis, shape (H, W); changed.
    """
    T_poster_camera = inverse(T_world_poster) @ np.asarray(T_world_camera)
    rays = rotate(T_poster_camera, camera_rays(pinhole))
    eye = transform_points(T_poster_camera, np.zeros(3))
    if eye[2] >= 0.0:  # seen from behind
        return
    down, across = np.gradient(rays, axis=(0, 1))
    _draw(
        rays, across, down, eye, poster.width / 2, poster.height / 2, poster.cells.astype(np.float32),
        np.asarray(light, dtype=float), radiance, depth,
    )  # fmt: skip
