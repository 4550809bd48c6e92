"""The arm as the camera sees it: the capsules of `bathbot_localize.arm.arm_shape`, and a brush with bristles.

The camera's masks are made from the same capsules; the arm drawn here is a little thinner than they say, as
they were taken from outlines on the wide side.
"""

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_points
from bathbot_localize.arm.arm_shape import RM65_CAPSULES
from bathbot_scrub.rm65.arm.kinematics import LINK_NAMES, T_FLANGE_HEAD, Kinematics
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.sim.render.mesh import Mesh, capsule_shape, cylinder_shape, merged, plain_mesh

SHELL = (0.72, 0.73, 0.75)
JOINT = (0.12, 0.13, 0.15)
SLIMMER = {SHELL: 0.003, JOINT: 0.006}  # [m] than the capsules; unlike, so that no two surfaces coincide
BRISTLES = (0.16, 0.38, 0.42)


class ArmMesh:
    """The RM65 with its scrub head, drawn at any joint angles."""

    def __init__(self, head: bool = True) -> None:
        """Make the shapes.

        Args:
            head: Whether the scrub head is mounted.
        """
        pieces = []
        for capsule in RM65_CAPSULES:
            if capsule.link == "scrub_head":
                continue
            colour = SHELL if capsule.link in ("Link2", "Link4", "base_link") else JOINT
            shape = capsule_shape(capsule.start, capsule.end, capsule.radius - SLIMMER[colour])
            pieces.append((LINK_NAMES.index(capsule.link), plain_mesh(*shape, colour, gloss=0.5)))
        if head:
            handle = cylinder_shape((0.0, 0.0, -0.10), (0.0, 0.0, -0.038), (0.018, 0.018))
            bristles = cylinder_shape((0.0, 0.0, -0.038), (0.0, 0.0, 0.0), (0.021, 0.019))
            pieces.append((len(LINK_NAMES), plain_mesh(*handle, SHELL, gloss=0.4)))
            pieces.append((len(LINK_NAMES), plain_mesh(*bristles, BRISTLES, gloss=0.0, grain=0.4)))
        self._mesh = merged([mesh for _, mesh in pieces])
        self._link = np.repeat([link for link, _ in pieces], [len(mesh.vertices) for _, mesh in pieces])

    @property
    def mesh(self) -> Mesh:
        """All shapes in the frames of their links."""
        return self._mesh

    def vertices(self, joints: ArrayLike) -> NDArray[np.float64]:
        """Points [m] in base_link at joint angles [rad], shape (6,) -> (V, 3)."""
        frames = Kinematics().link_frames(joints)
        frames = np.concatenate([frames, (frames[-1] @ T_FLANGE_HEAD)[None]])
        placed = np.empty_like(self._mesh.vertices)
        for link, frame in enumerate(frames):
            mine = self._link == link
            placed[mine] = transform_points(frame, self._mesh.vertices[mine])
        return placed
