"""Pictures of a lit stage: colour, true depth and part labels of every pixel.

One function serves the pictures a detector learns from and the simulated camera. Everything that rarely
changes (shadows, ambient occlusion) is computed once per stage; a picture is then a z-buffer and arithmetic
per pixel.
"""

from functools import lru_cache
from typing import NamedTuple

import cv2
import numba
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import rotate
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.body import Part, vertex_normals
from bathbot_bringup.sim.render.light import blocked, shaded
from bathbot_bringup.sim.render.raster import project_vertices, rasterise
from bathbot_bringup.sim.render.room import Room
from bathbot_bringup.sim.render.stage import Stage

Array = NDArray[np.float64]


_WAVES = np.random.default_rng(1).normal(size=(3, 8)) * np.repeat([60.0, 110.0, 180.0, 260.0], 2)
_WAVES = _WAVES.astype(np.float32)


class Rendering(NamedTuple):
    """What a perfect camera sees.

    Attributes:
        colour: sRGB, shape (H, W, 3) uint8.
        depth: Along the optical axis [m], NaN where nothing, shape (H, W) float32.
        parts: `Part` of each pixel, shape (H, W) uint8; NOT_SKIN for everything else.
        sides: `Side` of each pixel, shape (H, W) uint8.
        radiance: Linear light, shape (H, W, 3) float32, for weather and lens effects.
    """

    colour: NDArray[np.uint8]
    depth: NDArray[np.float32]
    parts: NDArray[np.uint8]
    sides: NDArray[np.uint8]
    radiance: NDArray[np.float32]


@lru_cache(maxsize=4)
def camera_rays(pinhole: Pinhole) -> Array:
    """Directions (x/z, y/z, 1) of all pixels, shape (H, W, 3)."""
    return pinhole.directions(pinhole.pixel_grid())


@lru_cache(maxsize=1)
def _grain() -> NDArray[np.float32]:
    """A cube of noise for fine texture, shape (64, 64, 64)."""
    rng = np.random.default_rng(0)
    cube = rng.normal(size=(64, 64, 64)).astype(np.float32)
    return (cube + np.roll(cube, 1, 0) + np.roll(cube, 1, 1) + np.roll(cube, 1, 2)) / 2.0


@numba.njit(cache=True, nogil=True)
def _mix(columns, faces, face, weights):
    out = np.empty((len(face), columns.shape[1]), dtype=np.float32)
    for i in range(len(face)):
        a, b, c = faces[face[i], 0], faces[face[i], 1], faces[face[i], 2]
        for k in range(columns.shape[1]):
            out[i, k] = (
                weights[i, 0] * columns[a, k] + weights[i, 1] * columns[b, k] + weights[i, 2] * columns[c, k]
            )
    return out


def _shade_mesh(
    stage: Stage, face: NDArray, weights: NDArray, views: Array, points: Array
) -> NDArray[np.float32]:
    """Light from the pixels that see the mesh, shape (N, 3)."""
    mesh = stage.mesh
    normals = vertex_normals(mesh.vertices, mesh.faces)
    columns = np.concatenate([
        mesh.albedo, normals, mesh.gloss[:, None], stage.occlusion[:, None], stage.visibility, mesh.texture,
        mesh.grain[:, None],
    ], axis=1).astype(np.float32)  # fmt: skip
    mixed = _mix(columns, mesh.faces, face, weights)
    surface, texture, grain = mixed[:, :-4], mixed[:, -4:-1], mixed[:, -1]
    fine, coarse = (
        _grain()[tuple((texture * per_metre).astype(np.int32).T & 63)] for per_metre in (700.0, 190.0)
    )
    surface[:, :3] *= (1.0 + grain * (0.6 * fine + 0.5 * coarse))[:, None]
    ripple = np.sin(texture @ _WAVES).sum(axis=1)  # water films and sweat break highlights up
    surface[:, 6] *= np.clip(0.9 + 0.35 * ripple + 0.25 * fine, 0.05, 3.0)
    return shaded(surface, views, points, stage.lighting)


def _shade_room(stage: Stage, views: Array, origin: Array, pixels: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Light from the pixels that see the room, (N, 3), and distance along their rays [m], (N,)."""
    hit = stage.room.hit(origin, views)
    points = origin + hit.distance[:, None] * views
    visibility = np.ones((len(views), len(stage.lighting.lamps)))
    coarse = np.zeros(pixels.shape, dtype=bool)
    coarse[::4, ::4] = True
    chosen = np.flatnonzero(coarse[pixels])
    rows, columns = (index[chosen] for index in np.nonzero(pixels))
    for number, lamp in enumerate(stage.lighting.lamps):
        towards = lamp.position - points[chosen]
        reach = np.linalg.norm(towards, axis=1, keepdims=True)
        picture = np.ones(pixels.shape, dtype=np.float32)
        picture[rows, columns] = ~blocked(
            stage.shadows, points[chosen] + 0.01 * hit.normals[chosen], towards / reach, 10.0
        )
        visibility[:, number] = _enlarged(picture[::4, ::4], pixels.shape)[pixels]
    columns = [hit.albedo, hit.normals, hit.gloss[:, None], np.ones((len(views), 1)), visibility]
    surface = np.concatenate(columns, axis=1).astype(np.float32)
    return shaded(surface, views, points, stage.lighting), hit.distance


def _enlarged(picture: NDArray[np.float32], shape: tuple[int, int]) -> NDArray[np.float32]:
    soft = cv2.GaussianBlur(picture, (0, 0), 1.5)
    return cv2.resize(soft, shape[::-1], interpolation=cv2.INTER_LINEAR)


@lru_cache(maxsize=1)
def _film() -> NDArray[np.uint8]:
    """SRGB bytes of linear light in steps of 1/8192, with a soft shoulder."""
    light = np.arange(4 * 8192) / 8192.0
    light = np.where(light < 0.6, light, 0.6 + 0.4 * np.tanh((light - 0.6) / 0.55))
    srgb = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-6) ** (1 / 2.4) - 0.055)
    return np.clip(np.round(255.0 * srgb), 0, 255).astype(np.uint8)


def developed(radiance: NDArray[np.float32]) -> NDArray[np.uint8]:
    """From linear light to sRGB bytes."""
    film = _film()
    return film[np.clip(radiance * np.float32(8192.0), 0.0, len(film) - 1).astype(np.int32)]


def depth_of_room(room: Room, pinhole: Pinhole, T_world_camera: ArrayLike) -> NDArray[np.float32]:
    """True distance of the empty room along the optical axis [m], shape (H, W)."""
    T_world_camera = np.asarray(T_world_camera, dtype=float)
    rays = rotate(T_world_camera, camera_rays(pinhole))
    return (
        room.distance(T_world_camera[:3, 3], rays.reshape(-1, 3)).reshape(rays.shape[:2]).astype(np.float32)
    )


def picture_of_room(stage: Stage, pinhole: Pinhole, T_world_camera: ArrayLike) -> Rendering:
    """The room with the shadows in it, without anything made of triangles."""
    T_world_camera = np.asarray(T_world_camera, dtype=float)
    rays = rotate(T_world_camera, camera_rays(pinhole)).reshape(-1, 3)
    stretch = np.linalg.norm(rays, axis=-1)
    shape = (pinhole.height, pinhole.width)
    everywhere = np.ones(shape, dtype=bool)
    radiance, distance = _shade_room(stage, rays / stretch[:, None], T_world_camera[:3, 3], everywhere)
    radiance = radiance.reshape(*shape, 3)
    depth = (distance / stretch).reshape(shape).astype(np.float32)
    parts = np.full(shape, Part.NOT_SKIN, dtype=np.uint8)
    return Rendering(developed(radiance), depth, parts, np.zeros(shape, dtype=np.uint8), radiance)


def draw(stage: Stage, pinhole: Pinhole, T_world_camera: ArrayLike, behind: Rendering) -> Rendering:
    """Draw a stage's triangles over a picture, where they are nearer than what it shows."""
    T_world_camera = np.asarray(T_world_camera, dtype=float)
    projected = project_vertices(stage.mesh.vertices, pinhole, T_world_camera)
    fragments = rasterise(projected, stage.mesh.faces, behind.depth)
    hit = fragments.face >= 0
    face, rays = fragments.face[hit], rotate(T_world_camera, camera_rays(pinhole)[hit])
    points = T_world_camera[:3, 3] + fragments.depth[hit][:, None] * rays
    views = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    colour, parts, sides, radiance = (plane.copy() for plane in (behind.colour, *behind[2:]))
    radiance[hit] = _shade_mesh(stage, face, fragments.weights[hit], views, points)
    colour[hit] = developed(radiance[hit])
    parts[hit], sides[hit] = stage.mesh.labels[face], stage.mesh.sides[face]
    return Rendering(colour, fragments.depth, parts, sides, radiance)


def render(stage: Stage, pinhole: Pinhole, T_world_camera: ArrayLike) -> Rendering:
    """Take one picture.

    Args:
        stage: The lit scene, world frame.
        pinhole: The camera; its distortion is honoured.
        T_world_camera: Maps the optical frame (z forward, x right, y down) to the world.
    """
    return draw(stage, pinhole, T_world_camera, picture_of_room(stage, pinhole, T_world_camera))
