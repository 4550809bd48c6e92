"""The arm as the camera sees it: the capsules of its shape, and a brush with bristles.

The camera's masks are made from the same capsules; the arm drawn here is a little thinner than they say, as
they were taken from outlines on the wide side.
"""

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_points
from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.installed_arm import installed_arm
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.render.mesh import Mesh, capsule_shape, cylinder_shape, merged, plain_mesh

SHELL = (0.72, 0.73, 0.75)
JOINT = (0.12, 0.13, 0.15)
TUBE = 0.10  # [m] a longer capsule is a tube between joints, and painted
SLIMMER = {SHELL: 0.003, JOINT: 0.006}  # [m] than the capsules; unlike, so that no two surfaces coincide
BRISTLES = (0.16, 0.38, 0.42)
HANDLE_SLIMMER, ROOT_SLIMMER, TIP_SLIMMER = 0.002, 0.004, 0.006  # [m] of the scrub head


class ArmMesh:
    """An arm with its scrub head, drawn at any joint angles."""

    def __init__(self, arm: Arm | None = None, head: bool = True) -> None:
        """Make the shapes.

        Args:
            arm: The one that is installed if left out.
            head: Whether the scrub head is mounted.
        """
        self._arm, pieces = arm or installed_arm(), []
        links, tool = self._arm.link_names, self._arm.tool
        for capsule in self._arm.shape.capsules:
            if capsule.link == tool.frame:
                continue
            colour = SHELL if np.linalg.norm(np.subtract(capsule.end, capsule.start)) > TUBE else JOINT
            shape = capsule_shape(capsule.start, capsule.end, capsule.radius - SLIMMER[colour])
            pieces.append((links.index(capsule.link), plain_mesh(*shape, colour, gloss=0.5)))
        if head:
            joint, grip = (0.0, 0.0, HANDLE_SLIMMER - tool.brush_height), tool.handle_radius - HANDLE_SLIMMER
            brush = (tool.brush_radius - ROOT_SLIMMER, tool.brush_radius - TIP_SLIMMER)
            handle = cylinder_shape((0.0, 0.0, -tool.length), joint, (grip, grip))
            bristles = cylinder_shape(joint, (0.0, 0.0, 0.0), brush)
            pieces.append((len(links), plain_mesh(*handle, SHELL, gloss=0.4)))
            pieces.append((len(links), plain_mesh(*bristles, BRISTLES, gloss=0.0, grain=0.4)))
        self._mesh = merged([mesh for _, mesh in pieces])
        self._link = np.repeat([link for link, _ in pieces], [len(mesh.vertices) for _, mesh in pieces])

    @property
    def mesh(self) -> Mesh:
        """All shapes in the frames of their links."""
        return self._mesh

    def vertices(self, joints: ArrayLike) -> NDArray[np.float64]:
        """Points [m] in base_link at joint angles [rad], shape (6,) -> (V, 3)."""
        frames = np.concatenate([self._arm.link_frames(joints), self._arm.head(joints)[None]])
        placed = np.empty_like(self._mesh.vertices)
        for link, frame in enumerate(frames):
            mine = self._link == link
            placed[mine] = transform_points(frame, self._mesh.vertices[mine])
        return placed
