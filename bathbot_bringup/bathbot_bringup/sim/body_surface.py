"""The moving skin as the arm's emulator and the judges meet it: rays against a ray scene that is built once.

Motion is applied to the rays, not to the triangles; breath, a few millimetres forward, moves the ray's origin
back by what the skin at the hit has moved.
"""

import numpy as np
import open3d as o3d
from bathbot_depthcorr.geometry.rigid import inverse, rotate, transform_points
from bathbot_perception.classes import SKIN_CLASSES
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.body import Body, breathing_weights
from bathbot_bringup.sim.render.light import ray_scene
from bathbot_bringup.sim.render.mesh import Mesh
from bathbot_bringup.sim.scenario import BodyMotion

Array = NDArray[np.float64]
_SETTLED = 1e-6  # [m] between two guesses of the breath's lift, where it is known


class BodySurface:
    """The skin and clothes of one moving person in the base frame."""

    def __init__(self, body: Body, dressed: Mesh, T_base_body: ArrayLike, motion: BodyMotion) -> None:
        """Build the ray scene.

        Args:
            body: The person, body frame.
            dressed: The same with clothes and hair: the surface that is met.
            T_base_body: Where the person sits.
            motion: How they move.
        """
        self._mesh, self._motion = dressed, motion
        self._T_base_body = np.asarray(T_base_body, dtype=float)
        self._weights = breathing_weights(body)
        self._scene = ray_scene(dressed.vertices, dressed.faces)

    def vertices(self, t: float) -> Array:
        """Points of the surface [m] in the base frame at time t [s], shape (V, 3)."""
        state = self._motion.at(t)
        breathed = self._mesh.vertices.copy()
        breathed[:, 0] += state.breath * self._weights
        return transform_points(self._T_base_body @ state.T_rest_moved, breathed)

    @property
    def faces(self) -> NDArray[np.int32]:
        """Corners of the triangles, shape (F, 3)."""
        return self._mesh.faces

    def distance(self, origins: Array, directions: Array, t: float) -> tuple[Array, Array, str]:
        """Meet the surface with rays.

        Args:
            origins: [m] in the base frame, shape (N, 3).
            directions: Unit vectors in the base frame, shape (N, 3).
            t: Time of the body [s].

        Returns:
            Distances [m], shape (N,), inf where nothing is met; outward normals, shape (N, 3), zero where
            nothing is met; class name of the skin under the first ray, empty for cloth, hair or nothing.
        """
        state = self._motion.at(t)
        T_base_moved = self._T_base_body @ state.T_rest_moved
        T_moved_base = inverse(T_base_moved)
        starts, aims = transform_points(T_moved_base, origins), rotate(T_moved_base, directions)
        lift = np.zeros(len(starts))
        rays = np.concatenate([starts, aims], axis=1).astype(np.float32)
        for _ in range(3 if state.breath else 1):
            rays[:, 0] = starts[:, 0] - lift
            hit = self._scene.cast_rays(o3d.core.Tensor(rays), nthreads=1)
            face, across = hit["primitive_ids"].numpy(), hit["primitive_uvs"].numpy()
            met = face != o3d.t.geometry.RaycastingScene.INVALID_ID
            face = np.where(met, face, 0)
            corners = self._weights[self._mesh.faces[face]]
            weights = corners[:, 0] + ((corners[:, 1:] - corners[:, :1]) * across).sum(axis=1)
            before, lift = lift, np.where(met, state.breath * weights, lift)
            if np.abs(lift - before).max(initial=0.0) < _SETTLED:
                break
        distances = np.where(met, hit["t_hit"].numpy().astype(float), np.inf)
        normals = hit["primitive_normals"].numpy().astype(float)
        normals = np.where(met[:, None], rotate(T_base_moved, normals), 0.0)
        label = int(self._mesh.labels[face[0]]) if len(met) and met[0] else len(SKIN_CLASSES)
        return distances, normals, SKIN_CLASSES[label] if label < len(SKIN_CLASSES) else ""

    def true_point(self, origin: ArrayLike, direction: ArrayLike, t: float) -> Array:
        """Where one ray, base frame, shape (3,) each, meets the surface [m], shape (3,); NaN if nowhere."""
        origin, direction = np.asarray(origin, dtype=float), np.asarray(direction, dtype=float)
        direction = direction / np.linalg.norm(direction)
        distance = self.distance(origin[None], direction[None], t)[0][0]
        return origin + distance * direction if np.isfinite(distance) else np.full(3, np.nan)
