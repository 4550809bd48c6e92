"""A lit scene - meshes, room, lamps, the light at each vertex - and where a camera looks at it from."""

from dataclasses import dataclass, replace

import numpy as np
import open3d as o3d
from bathbot_depthcorr.geometry.rigid import transform_from
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.body import vertex_normals
from bathbot_bringup.sim.render.light import Lighting, ambient_occlusion, lamp_visibility, ray_scene
from bathbot_bringup.sim.render.mesh import Mesh
from bathbot_bringup.sim.render.room import Room


def looking_at(eye: ArrayLike, target: ArrayLike, roll: float = 0.0) -> NDArray[np.float64]:
    """Pose of a camera's optical frame (z forward, x right, y down) in a world with z up.

    Args:
        eye: Where the camera is [m], shape (3,).
        target: What it looks at [m], shape (3,).
        roll: Turn about the optical axis [rad].

    Returns:
        T_world_camera, shape (4, 4).
    """
    eye, target = np.asarray(eye, dtype=float), np.asarray(target, dtype=float)
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross(z, (0.0, 0.0, 1.0))
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    c, s = np.cos(roll), np.sin(roll)
    return transform_from(np.stack([c * x + s * y, c * y - s * x, z], axis=-1), eye)


@dataclass(frozen=True, slots=True)
class Stage:
    """A lit scene in the world frame.

    Attributes:
        mesh: Everything made of triangles.
        room: The room around it.
        lighting: The light.
        occlusion: Share of the sky each vertex sees, shape (V,).
        visibility: Share of each lamp each vertex sees, shape (V, lamps).
        shadows: What casts shadows on the room.
    """

    mesh: Mesh
    room: Room
    lighting: Lighting
    occlusion: NDArray[np.float32]
    visibility: NDArray[np.float32]
    shadows: o3d.t.geometry.RaycastingScene

    def moved(self, vertices: ArrayLike) -> "Stage":
        """The stage after small motion: new vertices [m], shape (V, 3), the light as it was."""
        return replace(self, mesh=replace(self.mesh, vertices=np.asarray(vertices)))

    def split(self, vertices: int, faces: int) -> tuple["Stage", "Stage"]:
        """Two stages in the same light: the mesh's first vertices and faces, and the others."""
        first, rest = self.mesh.split(vertices, faces)
        return (
            replace(
                self, mesh=first, occlusion=self.occlusion[:vertices], visibility=self.visibility[:vertices]
            ),
            replace(
                self, mesh=rest, occlusion=self.occlusion[vertices:], visibility=self.visibility[vertices:]
            ),
        )

    def holding(self, mesh: Mesh) -> "Stage":
        """The same light on another mesh, which lies in no shadow."""
        count = len(mesh.vertices)
        lit = np.ones((count, self.visibility.shape[1]), dtype=np.float32)
        return replace(self, mesh=mesh, occlusion=np.ones(count, dtype=np.float32), visibility=lit)


def lit_stage(
    mesh: Mesh, room: Room, lighting: Lighting, rng: np.random.Generator,
    rays: int = 24, samples: int = 4,
) -> Stage:  # fmt: skip
    """Compute the light of a scene once.

    Args:
        mesh: Everything made of triangles.
        room: The room around it.
        lighting: The light.
        rng: For the rays.
        rays: Rays per vertex for ambient occlusion.
        samples: Rays per lamp and vertex.
    """
    scene = ray_scene(mesh.vertices, mesh.faces)
    normals = vertex_normals(mesh.vertices, mesh.faces)
    occlusion = ambient_occlusion(mesh.vertices, normals, scene, rng, rays)
    visibility = np.zeros((len(normals), len(lighting.lamps)), dtype=np.float32)
    for column, lamp in zip(visibility.T, lighting.lamps, strict=True):
        column[:] = lamp_visibility(mesh.vertices, normals, lamp, scene, rng, samples)
    return Stage(mesh, room, lighting, occlusion, visibility, scene)
