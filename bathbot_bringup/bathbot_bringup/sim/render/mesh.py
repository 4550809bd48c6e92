"""Triangle meshes with the surface properties a picture needs, and the simple shapes of a bathroom."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_points
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.body import Part

Array = NDArray[np.float64]

_PER_VERTEX = ("vertices", "albedo", "gloss", "texture", "grain")
_PER_FACE = ("labels", "sides")


@dataclass(frozen=True, slots=True)
class Mesh:
    """Triangles in the world frame.

    Attributes:
        vertices: [m], shape (V, 3).
        faces: Corners, counter-clockwise seen from outside, shape (F, 3).
        albedo: Linear reflectance 0..1 per vertex, shape (V, 3).
        gloss: Strength of the highlight per vertex, shape (V,).
        texture: Coordinates for fine texture [m], shape (V, 3); fixed to the surface.
        grain: Contrast of the fine texture per vertex, shape (V,).
        labels: `Part` of each face, shape (F,).
        sides: `Side` of each face, shape (F,).
    """

    vertices: Array
    faces: NDArray[np.int32]
    albedo: Array
    gloss: Array
    texture: Array
    grain: Array
    labels: NDArray[np.uint8]
    sides: NDArray[np.uint8]

    def placed(self, T_world_mesh: ArrayLike) -> "Mesh":
        """The same mesh elsewhere."""
        return replace(self, vertices=transform_points(T_world_mesh, self.vertices))

    def split(self, vertices: int, faces: int) -> tuple["Mesh", "Mesh"]:
        """The first vertices and faces, which must belong together, and the others."""
        first = {name: getattr(self, name)[:vertices] for name in _PER_VERTEX}
        rest = {name: getattr(self, name)[vertices:] for name in _PER_VERTEX}
        first |= {name: getattr(self, name)[:faces] for name in _PER_FACE}
        rest |= {name: getattr(self, name)[faces:] for name in _PER_FACE}
        return Mesh(faces=self.faces[:faces], **first), Mesh(faces=self.faces[faces:] - vertices, **rest)


def plain_mesh(
    vertices: ArrayLike, faces: ArrayLike, colour: ArrayLike, gloss: float = 0.1, grain: float = 0.05
) -> Mesh:
    """A thing that is not skin, of one colour, linear (3,) or per vertex (V, 3)."""
    vertices, faces = np.asarray(vertices, dtype=float), np.asarray(faces, dtype=np.int32)
    count = len(vertices)
    return Mesh(
        vertices=vertices,
        faces=faces,
        albedo=np.broadcast_to(np.asarray(colour, dtype=float), (count, 3)).copy(),
        gloss=np.full(count, gloss),
        texture=vertices.copy(),
        grain=np.full(count, grain),
        labels=np.full(len(faces), Part.NOT_SKIN, dtype=np.uint8),
        sides=np.zeros(len(faces), dtype=np.uint8),
    )


def merged(meshes: Sequence[Mesh]) -> Mesh:
    """All meshes as one, in order."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    faces = np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)])
    columns = {
        name: np.concatenate([getattr(mesh, name) for mesh in meshes]) for name in (*_PER_VERTEX, *_PER_FACE)
    }
    return Mesh(faces=faces.astype(np.int32), **columns)


def grid_faces(rows: int, columns: int) -> NDArray[np.int32]:
    """Triangles over a grid of vertices in row order, shape (2 (rows-1) (columns-1), 3)."""
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, :-1], index[1:, 1:]
    return np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])


def frame_along(direction: Array) -> Array:
    """A rotation whose z axis is a direction, shape (3, 3)."""
    z = direction / max(float(np.linalg.norm(direction)), 1e-12)
    helper = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 0.8 else np.array([0.0, 1.0, 0.0])
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def capsule_shape(
    start: ArrayLike, end: ArrayLike, radius: float, around: int = 20
) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and faces of a capsule between two points [m]."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length, rotation = float(np.linalg.norm(end - start)), frame_along(end - start)
    bow = np.linspace(-np.pi / 2, 0.0, 6)
    steps = np.linspace(0.0, length, max(int(length / 0.04), 1) + 1)
    height = np.concatenate([radius * np.sin(bow[:-1]), steps, length - radius * np.sin(bow[-2::-1])])
    width = np.concatenate(
        [radius * np.cos(bow[:-1]), np.full(len(steps), radius), radius * np.cos(bow[-2::-1])]
    )
    angle = np.linspace(0.0, 2.0 * np.pi, around + 1)
    points = np.stack(
        np.broadcast_arrays(width[:, None] * np.cos(angle), width[:, None] * np.sin(angle), height[:, None]),
        axis=-1,
    )
    return points.reshape(-1, 3) @ rotation.T + start, grid_faces(len(height), around + 1)


def cylinder_shape(
    start: ArrayLike, end: ArrayLike, radii: tuple[float, float], around: int = 28
) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and faces of a closed cylinder or cone between two points [m]."""
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    length, rotation = float(np.linalg.norm(end - start)), frame_along(end - start)
    steps = np.linspace(0.0, 1.0, max(int(length / 0.05), 1) + 1)
    height = np.concatenate([[0.0, 0.0], steps * length, [length, length]])
    wall = radii[0] + steps * (radii[1] - radii[0])
    width = np.concatenate([[0.0, radii[0]], wall, [radii[1], 0.0]])
    angle = np.linspace(0.0, 2.0 * np.pi, around + 1)
    points = np.stack(
        np.broadcast_arrays(width[:, None] * np.cos(angle), width[:, None] * np.sin(angle), height[:, None]),
        axis=-1,
    )
    return points.reshape(-1, 3) @ rotation.T + start, grid_faces(len(height), around + 1)


def box_shape(size: ArrayLike, cell: float = 0.06) -> tuple[Array, NDArray[np.int32]]:
    """Vertices and faces of a box [m] about the origin, its sides cut into small triangles."""
    size = np.asarray(size, dtype=float)
    points, faces, count = [], [], 0
    for axis in range(3):
        for sign in (-1.0, 1.0):
            u, v = ((axis + 1) % 3, (axis + 2) % 3) if sign > 0 else ((axis + 2) % 3, (axis + 1) % 3)
            n_u, n_v = (max(int(size[k] / cell), 1) + 1 for k in (u, v))
            side = np.zeros((n_v, n_u, 3))
            side[..., axis] = sign * size[axis] / 2
            side[..., u] = np.linspace(-0.5, 0.5, n_u) * size[u]
            side[..., v] = (np.linspace(-0.5, 0.5, n_v) * size[v])[:, None]
            points.append(side.reshape(-1, 3))
            faces.append(grid_faces(n_v, n_u) + count)
            count += n_u * n_v
    return np.concatenate(points), np.concatenate(faces)
