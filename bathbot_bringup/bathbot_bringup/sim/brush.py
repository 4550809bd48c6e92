"""The simulated brush on the simulated skin: bristles that give, then stiff skin.

Seven rays (centre and ring) along the head's z axis measure how far each bunch of bristles is bent.
The forces are a model, not measurements of any person.
"""

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from numpy.typing import NDArray

Array = NDArray[np.float64]

# [N/m] skin stiffness per class: ISO/TS 15066:2016 Table A.2 as transcribed publicly (chest for the
# trunk, upper arm, thigh; the foot has no row, so the lower leg's)
SKIN_STIFFNESS = {
    "Face_skin": 75e3,
    "Trunk_skin": 25e3,
    "Upperlimb_skin": 30e3,
    "Lowerlimb_skin": 50e3,
    "Hand_skin": 75e3,
    "Foot_skin": 60e3,
}
_OTHER_STIFFNESS = 50e3  # [N/m] chair, wall, clothes over flesh
_BACK = 0.06  # [m] behind the tip where rays begin, so that they begin outside the skin
_SLIP_SPEED = 0.005  # [m/s] at which friction is nearly full


class SkinSurface(Protocol):
    """Anything the brush can touch."""

    def distance(self, origins: Array, directions: Array, t: float) -> tuple[Array, Array, str]:
        """Meet rays, origins [m] and unit directions (N, 3) in base_link, with the body at time t [s].

        Returns:
            Distances [m], shape (N,), inf where nothing is hit; outward unit normals, shape (N, 3); name of
            the class under the first ray, empty when it hits nothing.
        """


class Contact(NamedTuple):
    """Truth about brush and skin at one instant, in the base frame."""

    compression: float  # [m] bend of the middle bristles, 0..give; negative: gap to the skin
    indentation: float  # [m] of the skin beyond the bristles' give
    force: Array  # [N] on the head, shape (3,)
    torque: Array  # [Nm] on the head about its tip, shape (3,)
    part: str  # class name; empty: none


@dataclass(frozen=True, slots=True)
class Brush:
    """A round soft brush."""

    radius: float = SCRUB_HEAD.brush_radius  # [m]
    give: float = SCRUB_HEAD.give  # [m] that bristles bend
    stiffness: float = 400.0  # [N/m] of all bristles together, 0.4 N/mm
    friction: float = 0.3  # of wet bristles on skin; ours
    _ring: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Lay out the rays: centre and six on a ring that halves the area."""
        angles = np.arange(6) * np.pi / 3
        ring = self.radius / np.sqrt(2.0) * np.stack([np.cos(angles), np.sin(angles), np.zeros(6)], -1)
        object.__setattr__(self, "_ring", np.vstack([np.zeros((1, 3)), ring]))

    def normal_force(self, bend: Array, skin_stiffness: float) -> Array:
        """Force [N] of the whole brush pressed in by `bend` [m], shape (...): bristles, then skin."""
        bend = np.maximum(bend, 0.0)
        return self.stiffness * np.minimum(bend, self.give) + skin_stiffness * np.maximum(
            bend - self.give, 0.0
        )

    def touch(self, T_base_head: Array, velocity: Array, surface: SkinSurface, t: float) -> Contact:
        """Press the brush on the surface.

        Args:
            T_base_head: Pose of the head, (4, 4); origin at the tip of unbent bristles.
            velocity: Of the tip in the base frame [m/s], shape (3,).
            surface: What it may touch.
            t: Time of the body [s].
        """
        approach = T_base_head[:3, 2]
        offsets = self._ring @ T_base_head[:3, :3].T
        origins = T_base_head[:3, 3] + offsets - _BACK * approach
        distances, _, part = surface.distance(origins, np.broadcast_to(approach, origins.shape), t)
        bend = _BACK - np.minimum(distances, 1.0)
        forces = self.normal_force(bend, SKIN_STIFFNESS.get(part, _OTHER_STIFFNESS)) / len(bend)
        slip = velocity - (velocity @ approach) * approach
        speed = float(np.linalg.norm(slip))
        drag = self.friction * np.tanh(speed / _SLIP_SPEED) / max(speed, 1e-9) * slip
        pushes = -forces[:, None] * (approach + drag)
        middle = float(bend[0])
        return Contact(
            compression=min(middle, self.give),
            indentation=max(middle - self.give, 0.0),
            force=pushes.sum(0),
            torque=_torque(offsets, pushes),
            part=part if bend.max() > 0.0 else "",
        )


def _torque(arms: Array, forces: Array) -> Array:
    """Sum of arm x force, shape (N, 3) each, in less time than `np.cross` takes for a few."""
    products = arms.T @ forces  # the antisymmetric part of the sum of a_i f_j
    return np.array([
        products[1, 2] - products[2, 1], products[2, 0] - products[0, 2], products[0, 1] - products[1, 0]
    ])  # fmt: skip
