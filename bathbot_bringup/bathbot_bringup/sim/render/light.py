"""Lamps, and what of their light and of the sky reaches a surface: shadows, occlusion by ray casting."""

from dataclasses import dataclass
from typing import NamedTuple

import numba
import numpy as np
import open3d as o3d
from numpy.typing import NDArray

Array = NDArray[np.float64]

CLOSEST = 0.6  # [m^2]; nearer lamps do not get brighter, as a camera would shorten its exposure


class Lamp(NamedTuple):
    """A ball of light: place [m], shape (3,), linear colour at one metre, shape (3,), radius [m]."""

    position: Array
    colour: Array
    radius: float


@dataclass(frozen=True, slots=True)
class Lighting:
    """All light of a room: from above, from below (both linear colours, shape (3,)), and lamps."""

    sky: Array
    ground: Array
    lamps: tuple[Lamp, ...]

    def scaled(self, factor: float) -> "Lighting":
        """All of it brighter by a factor."""
        lamps = tuple(lamp._replace(colour=factor * lamp.colour) for lamp in self.lamps)
        return Lighting(factor * self.sky, factor * self.ground, lamps)


@numba.njit(cache=True, nogil=True, fastmath=True)
def _shade(surface, views, points, sky, ground, lamp_places, lamp_colours, out):
    for i in range(len(surface)):
        s = surface[i]
        nx, ny, nz = s[3], s[4], s[5]
        length = 1.0 / max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-6)
        nx, ny, nz = nx * length, ny * length, nz * length
        up = 0.5 * (1.0 + nz)
        for c in range(3):
            out[i, c] = s[c] * s[7] * (ground[c] + up * (sky[c] - ground[c]))
        for k in range(len(lamp_places)):
            x, y = lamp_places[k, 0] - points[i, 0], lamp_places[k, 1] - points[i, 1]
            z = lamp_places[k, 2] - points[i, 2]
            square = x * x + y * y + z * z
            share = s[8 + k] / max(square, CLOSEST)
            if share <= 0.0:
                continue
            length = 1.0 / np.sqrt(square)
            x, y, z = x * length, y * length, z * length
            cosine = max(nx * x + ny * y + nz * z, 0.0)
            hx, hy, hz = x - views[i, 0], y - views[i, 1], z - views[i, 2]
            peak = max((nx * hx + ny * hy + nz * hz) / max(np.sqrt(hx * hx + hy * hy + hz * hz), 1e-6), 0.0)
            shine = s[6] * (0.25 * peak**18 + 0.9 * peak**90)
            for c in range(3):
                out[i, c] += share * (s[c] * cosine + shine) * lamp_colours[k, c]


def shaded(
    surface: NDArray[np.float32], views: Array, points: Array, lighting: Lighting
) -> NDArray[np.float32]:
    """Light leaving surface points towards the camera: Lambert, Blinn-Phong and ambient light.

    Args:
        surface: Albedo (3), normal (3), gloss, sky seen, share of each lamp seen; shape (N, 8 + lamps).
        views: Unit rays from the camera, shape (N, 3).
        points: Where they meet the surface [m], shape (N, 3).
        lighting: The light.

    Returns:
        Linear light, shape (N, 3).
    """
    out = np.empty((len(surface), 3), dtype=np.float32)
    places = np.array([lamp.position for lamp in lighting.lamps], dtype=float).reshape(-1, 3)
    colours = np.array([lamp.colour for lamp in lighting.lamps], dtype=float).reshape(-1, 3)
    _shade(surface, views, points, lighting.sky, lighting.ground, places, colours, out)
    return out


def ray_scene(vertices: Array, faces: NDArray[np.int32]) -> o3d.t.geometry.RaycastingScene:
    """Triangles that rays can be cast against, in one thread."""
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(
        o3d.core.Tensor(np.ascontiguousarray(vertices, dtype=np.float32)),
        o3d.core.Tensor(np.ascontiguousarray(faces, dtype=np.uint32)),
    )
    return scene


def blocked(
    scene: o3d.t.geometry.RaycastingScene, origins: Array, directions: Array, reach: float
) -> NDArray[np.bool_]:
    """Whether something lies within a reach [m] of each ray, shape (N, 3) -> (N,)."""
    rays = np.concatenate([origins, directions], axis=1).astype(np.float32)
    return scene.test_occlusions(o3d.core.Tensor(rays), tnear=0.0, tfar=reach, nthreads=1).numpy()


def ambient_occlusion(
    vertices: Array,
    normals: Array,
    scene: o3d.t.geometry.RaycastingScene,
    rng: np.random.Generator,
    rays: int = 24,
    reach: float = 0.35,
) -> NDArray[np.float32]:
    """Share of the sky each point sees, 0..1, shape (N,); cosine-weighted rays of limited reach [m]."""
    seen = np.zeros(len(vertices), dtype=np.float32)
    origins = vertices + 0.002 * normals
    for _ in range(rays):
        ball = rng.normal(size=vertices.shape)
        directions = normals + ball / np.linalg.norm(ball, axis=1, keepdims=True)
        directions /= np.maximum(np.linalg.norm(directions, axis=1, keepdims=True), 1e-6)
        seen += ~blocked(scene, origins, directions, reach)
    return seen / rays


def lamp_visibility(
    points: Array,
    normals: Array,
    lamp: Lamp,
    scene: o3d.t.geometry.RaycastingScene,
    rng: np.random.Generator,
    samples: int = 4,
) -> NDArray[np.float32]:
    """Share of a lamp each point sees, 0..1, shape (N,); zero where the surface looks away."""
    share = np.zeros(len(points), dtype=np.float32)
    facing = np.flatnonzero(((lamp.position - points) * normals).sum(axis=1) > 0.0)
    for _ in range(samples):
        ball = rng.normal(size=3)
        towards = lamp.position + lamp.radius * ball / np.linalg.norm(ball) - points[facing]
        distance = np.linalg.norm(towards, axis=1, keepdims=True)
        share[facing] += ~blocked(scene, points[facing] + 0.003 * normals[facing], towards / distance, 10.0)
    return share / samples
