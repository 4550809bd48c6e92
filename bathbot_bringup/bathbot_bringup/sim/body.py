"""Seated bodies: meshes with part labels, made by `scripts/make_bodies.py` from the Anny body model.

Body frame: origin at the pelvis on the seat, x the facing direction, y to the person's left, z up.
"""

from dataclasses import dataclass, replace
from enum import IntEnum
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.errors import BringupError

BODIES = Path(__file__).parent / "data" / "bodies.npz"


class Part(IntEnum):
    """The six skin classes, in the detector's order, and everything else."""

    FACE = 0
    TRUNK = 1
    UPPER_LIMB = 2
    LOWER_LIMB = 3
    HAND = 4
    FOOT = 5
    NOT_SKIN = 6


class Mark(IntEnum):
    """What a painter needs to know about a vertex beside its part."""

    PLAIN = 0
    SCALP = 1
    EYE = 2
    LIPS = 3
    BROW = 4
    NIPPLE = 5


class Side(IntEnum):
    """Which of a pair a vertex belongs to."""

    MIDDLE = 0
    LEFT = 1
    RIGHT = 2


class UnknownBodyError(BringupError):
    """A body number that the file does not hold."""


@dataclass(frozen=True, slots=True)
class Body:
    """One seated person in the body frame.

    Attributes:
        vertices: Points of the skin [m], shape (V, 3).
        faces: Corners of the triangles, outward counter-clockwise, shape (F, 3).
        parts: `Part` of each vertex, shape (V,).
        marks: `Mark` of each vertex, shape (V,).
        sides: `Side` of each vertex, shape (V,).
        fraction: 0..1 from hip to knee on legs and from pelvis to neck on the trunk, shape (V,).
        rest: The vertices of the mean standing body [m], shape (V, 3): coordinates for textures.
        landmarks: Joint centres [m] by name.
        male: Sex of the shape.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    parts: NDArray[np.uint8]
    marks: NDArray[np.uint8]
    sides: NDArray[np.uint8]
    fraction: NDArray[np.float64]
    rest: NDArray[np.float64]
    landmarks: dict[str, NDArray[np.float64]]
    male: bool

    def moved(self, vertices: ArrayLike) -> "Body":
        """The same person with other vertices [m], shape (V, 3)."""
        return replace(self, vertices=np.asarray(vertices))


@lru_cache(maxsize=2)
def _stored(path: Path) -> dict[str, np.ndarray]:
    with np.load(path) as archive:
        return {name: archive[name] for name in archive.files}


def body_count(path: Path = BODIES) -> int:
    """Number of bodies in a file."""
    return len(_stored(path)["vertices"])


def load_body(index: int, path: Path = BODIES) -> Body:
    """Read one body.

    Raises:
        UnknownBodyError: If the file does not hold it.
    """
    stored = _stored(path)
    if not 0 <= index < len(stored["vertices"]):
        raise UnknownBodyError(f"{path.name} holds bodies 0..{len(stored['vertices']) - 1}, got {index}")
    unit, rest, parts = float(stored["unit"]), stored["rest"] * float(stored["unit"]), stored["parts"]
    paired = ~np.isin(parts, (Part.FACE, Part.TRUNK))
    sides = np.where(paired, np.where(rest[:, 1] > 0.0, Side.LEFT, Side.RIGHT), Side.MIDDLE)
    return Body(
        vertices=stored["vertices"][index] * unit,
        faces=stored["faces"].astype(np.int32),
        parts=parts,
        marks=stored["marks"],
        sides=sides.astype(np.uint8),
        fraction=stored["fraction"] / 255.0,
        rest=rest,
        landmarks=dict(
            zip(stored["landmark_names"].tolist(), stored["landmarks"][index].astype(float), strict=True)
        ),
        male=bool(stored["male"][index]),
    )


def vertex_normals(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    """Outward unit normals, area-weighted over the triangles around a vertex, shape (V, 3)."""
    corners = vertices[faces]
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.stack(
        [np.bincount(faces.ravel(), np.repeat(facing[:, axis], 3), len(vertices)) for axis in range(3)],
        axis=-1,
    )
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)


def smoothed(values: NDArray[np.float64], faces: NDArray[np.int32], rounds: int) -> NDArray[np.float64]:
    """Average a quantity per vertex, shape (V,), with its neighbours, over and over."""
    a, b = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).T
    count = np.maximum(np.bincount(a, minlength=len(values)), 1)
    for _ in range(rounds):
        values = 0.5 * values + 0.5 * np.bincount(a, values[b], len(values)) / count
    return values


def breathing_weights(body: Body) -> NDArray[np.float64]:
    """How much of the breath moves a vertex forward, 0..1, shape (V,): the front of chest and belly."""
    front = np.clip(vertex_normals(body.vertices, body.faces)[:, 0], 0.0, 1.0)
    height = np.exp(-(((body.fraction - 0.5) / 0.25) ** 2))
    weights = smoothed(np.where(body.parts == Part.TRUNK, front * height, 0.0), body.faces, rounds=12)
    return weights / weights.max()
