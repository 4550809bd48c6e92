"""Which bare skin of a scene the arm can press its brush on, by the arm's own kinematics."""

from typing import NamedTuple

import numpy as np
from bathbot_bringup.sim.body import Part, vertex_normals
from bathbot_bringup.sim.render.light import blocked, ray_scene
from bathbot_bringup.sim.scene import BathroomScene
from bathbot_depthcorr.geometry.rigid import rotate, transform_points
from bathbot_scrub.installed_arm import installed_arm
from numpy.typing import NDArray

Array = NDArray[np.float64]

REGIONS = {
    "trunk": Part.TRUNK, "upper limb": Part.UPPER_LIMB, "thigh": Part.LOWER_LIMB, "face": Part.FACE,
    "hand": Part.HAND, "foot": Part.FOOT,
}  # fmt: skip


class ReachableArea(NamedTuple):
    """Bare skin of one region [m^2]: what the camera sees of it, and what the arm reaches of that."""

    visible: float
    reachable: float


def head_poses(points: Array, normals: Array, turns: int = 4) -> Array:
    """Poses of the scrub head on skin, z into it, at several turns about z, shape (N, turns, 4, 4)."""
    z = -normals
    helper = np.where(np.abs(z[:, :1]) < 0.8, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    x = np.cross(helper, z)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(z, x)
    angles = 2.0 * np.pi * np.arange(turns) / turns
    poses = np.zeros((len(points), turns, 4, 4))
    for k, angle in enumerate(angles):
        along = np.cos(angle) * x + np.sin(angle) * y
        poses[:, k, :3, :3] = np.stack([along, np.cross(z, along), z], axis=-1)
    poses[..., :3, 3], poses[..., 3, 3] = points[:, None], 1.0
    return poses


def reachable_areas(scene: BathroomScene) -> dict[str, ReachableArea]:
    """Area of skin seen and reached, per region, of the person at rest."""
    mesh = scene.dressed
    vertices = transform_points(scene.T_base_body, mesh.vertices)
    corners = vertices[mesh.faces]
    normals = rotate(scene.T_base_body, vertex_normals(mesh.vertices, mesh.faces))[mesh.faces].mean(axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    centres = corners.mean(axis=1)
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    towards = scene.T_base_camera[:3, 3] - centres
    distance = np.linalg.norm(towards, axis=1)
    towards /= distance[:, None]
    seen = (towards * normals).sum(axis=1) > 0.1
    seen &= ~blocked(ray_scene(vertices, mesh.faces), centres + 0.002 * normals, towards, 2.0)
    result = {}
    for name, part in REGIONS.items():
        mine = seen & (mesh.labels == part)
        if name == "thigh":
            mine &= scene.body.fraction[mesh.faces[:, 0]] < 0.95
        solutions = installed_arm().solve_head(head_poses(centres[mine], normals[mine]))
        reached = np.isfinite(solutions).all(axis=-1).any(axis=(-1, -2))
        result[name] = ReachableArea(float(areas[mine].sum()), float(areas[mine][reached].sum()))
    return result
