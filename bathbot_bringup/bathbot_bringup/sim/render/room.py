"""A tiled room: six planes hit analytically, so tile joints are sharp and no triangle is spent."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class RoomHit(NamedTuple):
    """Where rays meet the room: distance along the ray, normals (N, 3), albedo (N, 3), gloss (N,)."""

    distance: Array
    normals: Array
    albedo: Array
    gloss: Array


@dataclass(frozen=True, slots=True)
class Tiles:
    """One tiled surface: tile size [m] (2,), joint width [m], linear colours, spread between tiles, gloss."""

    size: tuple[float, float]
    joint: float
    colour: tuple[float, float, float]
    joint_colour: tuple[float, float, float]
    variation: float
    gloss: float


@dataclass(frozen=True, slots=True)
class Room:
    """A box of walls, floor and ceiling in the world frame.

    Attributes:
        low: Corner with the smallest coordinates [m], shape (3,).
        high: Corner with the largest coordinates [m], shape (3,).
        walls: Surface of the four walls.
        floor: Surface of the floor.
        ceiling: Linear colour of the ceiling.
    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    walls: Tiles
    floor: Tiles
    ceiling: tuple[float, float, float]

    def distance(self, origin: Array, directions: Array) -> Array:
        """Lengths of directions, shape (N, 3), from a point inside, shape (3,), to the room, shape (N,)."""
        return self._exits(origin, directions).min(axis=1)

    def _exits(self, origin: Array, directions: Array) -> Array:
        """The same for the pair of planes across each axis, shape (N, 3)."""
        low, high = np.asarray(self.low), np.asarray(self.high)
        with np.errstate(divide="ignore", invalid="ignore"):
            exits = np.where(directions > 0.0, high - origin, low - origin) / directions
        return np.where(np.abs(directions) < 1e-12, np.inf, exits)

    def hit(self, origin: Array, directions: Array) -> RoomHit:
        """Meet the room from a point inside it, shape (3,), along directions, shape (N, 3)."""
        exits = self._exits(origin, directions)
        axis = exits.argmin(axis=1)
        rows = np.arange(len(directions))
        distance = exits[rows, axis]
        points = origin + distance[:, None] * directions
        sign = np.sign(directions[rows, axis])
        normals = np.zeros_like(directions)
        normals[rows, axis] = -sign
        albedo, gloss = np.empty_like(points), np.empty(len(points))
        for surface, mask in (
            (self.walls, axis < 2), (self.floor, (axis == 2) & (sign < 0)), (None, (axis == 2) & (sign > 0)),
        ):  # fmt: skip
            if surface is None:
                albedo[mask], gloss[mask] = self.ceiling, 0.0
                continue
            across = np.where(axis[mask] == 0, points[mask, 1], points[mask, 0])
            along = np.where(axis[mask] == 2, points[mask, 1], points[mask, 2])
            seed = (2 * axis + (sign > 0))[mask]
            albedo[mask], gloss[mask] = tile_colours(surface, across, along, distance[mask], seed)
        return RoomHit(distance, normals, albedo, gloss)


def tile_colours(
    tiles: Tiles, across: Array, along: Array, distance: Array, seed: Array
) -> tuple[Array, Array]:
    """Linear colour (N, 3) and gloss (N,) of places [m] on tiles; distance [m] softens the joints."""
    u, v = across / tiles.size[0], along / tiles.size[1]
    column, row = np.floor(u), np.floor(v)
    edge = np.minimum(
        (0.5 - np.abs(u - column - 0.5)) * tiles.size[0], (0.5 - np.abs(v - row - 0.5)) * tiles.size[1]
    )
    blur = 0.0012 * distance + 1e-4
    joint = 1.0 - np.clip((edge - tiles.joint / 2) / blur + 0.5, 0.0, 1.0)
    shade = 1.0 + tiles.variation * (2.0 * scatter(column, row, seed) - 1.0)
    tile = np.asarray(tiles.colour) * shade[:, None]
    colour = tile + joint[:, None] * (np.asarray(tiles.joint_colour) - tile)
    return colour, tiles.gloss * (1.0 - joint)


def scatter(column: Array, row: Array, seed: Array) -> Array:
    """A fixed pseudo-random number 0..1 per tile."""
    value = np.sin(column * 12.9898 + row * 78.233 + seed * 37.719) * 43758.5453
    return value - np.floor(value)
