"""Rooms, lamps and furniture of a bathroom, drawn at random."""

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_from
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.render.light import Lamp, Lighting
from bathbot_bringup.sim.render.mesh import Mesh, box_shape, capsule_shape, cylinder_shape, plain_mesh
from bathbot_bringup.sim.render.room import Room, Tiles

Array = NDArray[np.float64]

TILE_COLOURS = (
    (0.75, 0.76, 0.75), (0.62, 0.66, 0.68), (0.55, 0.48, 0.38), (0.30, 0.42, 0.48), (0.16, 0.18, 0.2),
    (0.66, 0.58, 0.48), (0.45, 0.55, 0.5), (0.50, 0.36, 0.27),
)  # fmt: skip


def random_tiles(rng: np.random.Generator) -> Tiles:
    """Draw a tiled surface; some are the colour of skin or wood."""
    size = float(rng.choice([0.05, 0.1, 0.15, 0.2, 0.3, 0.6]))
    colour = np.clip(
        np.array(TILE_COLOURS[rng.integers(len(TILE_COLOURS))]) * rng.uniform(0.8, 1.15), 0.02, 0.85
    )
    joint = np.clip(colour * rng.uniform(0.4, 0.8) if rng.uniform() < 0.7 else np.full(3, 0.7), 0.02, 0.85)
    return Tiles(
        size=(size, size * float(rng.choice([1.0, 0.5, 2.0]))),
        joint=float(rng.uniform(0.002, 0.006)),
        colour=tuple(colour),
        joint_colour=tuple(joint),
        variation=float(rng.uniform(0.0, 0.15)),
        gloss=float(rng.uniform(0.05, 0.5)),
    )


def random_room(rng: np.random.Generator, low: ArrayLike, high: ArrayLike) -> Room:
    """Draw the surfaces of a room that encloses a box [m] with some space to spare."""
    space = rng.uniform(0.1, 1.1, size=4)
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return Room(
        low=(low[0] - space[0], low[1] - space[1], low[2]),
        high=(high[0] + space[2], high[1] + space[3], low[2] + rng.uniform(2.3, 2.7)),
        walls=random_tiles(rng),
        floor=random_tiles(rng),
        ceiling=(0.8, 0.8, 0.78),
    )


def random_lighting(rng: np.random.Generator, room: Room) -> Lighting:
    """Draw warm or cold light: one ceiling lamp, often a second one or a window."""
    low, high = np.array(room.low), np.array(room.high)
    lamps = []
    for number in range(rng.integers(1, 3)):
        share = rng.uniform((0.15, 0.15, 0.8 if number == 0 else 0.4), (0.85, 0.85, 0.97))
        warm = rng.uniform(-0.25, 0.25)
        colour = np.array([1.0 + warm, 1.0, 1.0 - warm]) * rng.uniform(0.5, 2.2)
        lamps.append(Lamp(low + share * (high - low), colour, float(rng.uniform(0.05, 0.4))))
    level = rng.uniform(0.12, 0.6)
    sky = level * (1.0 + rng.normal(0, 0.05, 3))
    return Lighting(sky, sky * rng.uniform(0.3, 0.6), tuple(lamps))


def stool(seat: ArrayLike, floor: float, rng: np.random.Generator) -> list[Mesh]:
    """A shower stool with four legs under a seat point [m]."""
    seat = np.asarray(seat, dtype=float)
    colour = ((0.75, 0.75, 0.73), (0.2, 0.3, 0.35), (0.35, 0.25, 0.15))[rng.integers(3)]
    top = plain_mesh(
        *cylinder_shape(seat - (0, 0, 0.045), seat - (0, 0, 0.004), (0.165, 0.17)), colour, gloss=0.3
    )
    legs = []
    for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        start, end = (
            np.add(seat, (0.11 * x, 0.11 * y, -0.045)),
            np.array([seat[0] + 0.15 * x, seat[1] + 0.15 * y, floor]),
        )
        legs.append(
            plain_mesh(*cylinder_shape(start, end, (0.012, 0.012), around=10), (0.6, 0.6, 0.62), gloss=0.5)
        )
    return [top, *legs]


def towel(place: Array, facing: float, rng: np.random.Generator) -> Mesh:
    """A towel hanging flat at a place [m], turned about z by an angle [rad]."""
    width, height = rng.uniform(0.25, 0.5), rng.uniform(0.4, 0.8)
    vertices, faces = box_shape((0.03, width, height), cell=0.03)
    vertices[:, 0] += 0.012 * np.sin(vertices[:, 1] * rng.uniform(25, 60))
    colour = np.clip(rng.uniform(0.1, 0.85) * (1 + rng.normal(0, 0.25, 3)), 0.02, 0.9)
    c, s = np.cos(facing), np.sin(facing)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return plain_mesh(vertices, faces, colour, gloss=0.0, grain=0.2).placed(transform_from(turn, place))


def clutter(rng: np.random.Generator, room: Room) -> list[Mesh]:
    """Towels, bars, bottles and buckets along the walls; some wooden or skin-coloured."""
    low, high = np.array(room.low), np.array(room.high)
    things = []
    for _ in range(rng.integers(0, 3)):
        y = rng.uniform(low[1] + 0.3, high[1] - 0.3)
        things.append(towel(np.array([low[0] + 0.05, y, low[2] + rng.uniform(0.8, 1.5)]), 0.0, rng))
    for _ in range(rng.integers(0, 3)):
        x = rng.uniform(low[0] + 0.3, high[0] - 0.3)
        side = low[1] + 0.05 if rng.uniform() < 0.5 else high[1] - 0.05
        things.append(towel(np.array([x, side, low[2] + rng.uniform(0.8, 1.5)]), np.pi / 2, rng))
    for _ in range(rng.integers(0, 5)):  # grab bars and hoses
        start = rng.uniform(low + 0.08, high - 0.08)
        start[0] = low[0] + 0.07
        end = start + rng.uniform((0.0, -0.4, -0.4), (0.02, 0.4, 0.4))
        colour = (0.6, 0.6, 0.62) if rng.uniform() < 0.6 else (0.5, 0.36, 0.25)
        things.append(plain_mesh(*capsule_shape(start, end, 0.015, around=10), colour, gloss=1.0))
    for _ in range(rng.integers(0, 6)):  # bottles, buckets
        foot = np.array(
            [rng.uniform(low[0] + 0.1, high[0] - 0.2), rng.uniform(low[1] + 0.1, high[1] - 0.1), low[2]]
        )
        if np.hypot(*foot[:2]) < 0.45:
            continue
        radius, height = rng.uniform(0.03, 0.16), rng.uniform(0.1, 0.35)
        colour = np.clip(rng.uniform(0.05, 0.8) * (1 + rng.normal(0, 0.4, 3)), 0.02, 0.9)
        shape = cylinder_shape(foot, np.add(foot, (0, 0, height)), (radius * 0.9, radius))
        things.append(plain_mesh(*shape, colour, gloss=0.4))
    return things


def arm_like(rng: np.random.Generator, base: Array, tip: Array, floor: float) -> list[Mesh]:
    """A robot arm's likeness on its pedestal: from a base to a tip [m], bent upwards."""
    shell = ((0.75, 0.75, 0.76), (0.12, 0.12, 0.13), (0.6, 0.62, 0.65))[rng.integers(3)]
    shoulder = np.add(base, (0, 0, 0.24))
    wrist = (
        tip
        + 0.27 * (shoulder - tip) / max(np.linalg.norm(shoulder - tip), 1e-6)
        + (0, 0, rng.uniform(0.0, 0.12))
    )
    elbow = 0.5 * (shoulder + wrist) + (*rng.normal(0, 0.08, 2), rng.uniform(0.1, 0.28))
    joints = [base, shoulder, elbow, wrist, tip]
    radii = (0.06, 0.05, 0.042, 0.035)
    things = [
        plain_mesh(*capsule_shape(a, b, radius), shell, gloss=0.5)
        for a, b, radius in zip(joints[:-1], joints[1:], radii, strict=True)
    ]
    end = tip + 0.03 * (tip - wrist) / max(np.linalg.norm(tip - wrist), 1e-6)
    brush = np.clip(rng.uniform(0.1, 0.8, 3), 0.02, 0.9)
    things.append(plain_mesh(*cylinder_shape(tip, end, (0.028, 0.025)), brush, gloss=0.0, grain=0.4))
    pedestal = cylinder_shape((base[0], base[1], floor), base, (0.09, 0.08))
    return [*things, plain_mesh(*pedestal, (0.3, 0.3, 0.32), gloss=0.4)]
