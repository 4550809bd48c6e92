"""A person as a plane of skin that leans towards the arm, breathes and sways, and what is seen of it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.arm.emulator.surface import PlaneSurface

Array = NDArray[np.float64]
_HALF_WIDTH, _HALF_HEIGHT, _SPACING = 0.25, 0.35, 0.02  # [m] of the cloud; its points are so far apart


class Lean(NamedTuple):
    """A move along the skin's outward normal, straight and at one speed."""

    begin: float  # [s]
    distance: float  # [m] towards the arm; negative: away from it
    speed: float  # [m/s], positive


class Sway(NamedTuple):
    """A move to and fro along the skin's normal, as of breathing."""

    amplitude: float  # [m]
    frequency: float  # [Hz]
    phase: float = 0.0  # [rad]


class Person:
    """A `SkinSurface`; z of its frame points into the skin."""

    def __init__(self, T_base_skin: Array, region: str, sways: tuple[Sway, ...] = ()) -> None:
        """Sit still, but for `sways`, with skin of a region through the origin of a frame, (4, 4)."""
        self.T_base_skin, self._sways, self._leans = T_base_skin, sways, list[Lean]()
        self.outward = -T_base_skin[:3, 2]
        offset = float(self.outward @ T_base_skin[:3, 3])
        self._plane = PlaneSurface(tuple(self.outward), offset, region, self.shift)

    def lean(self, lean: Lean) -> None:
        """Have the person lean; leans add up."""
        self._leans.append(lean)

    def shift(self, t: float) -> float:
        """How far the skin is towards the arm at `t` [s], from where it was at first [m]."""
        leant = sum(
            float(np.sign(lean.distance)) * min(max(lean.speed * (t - lean.begin), 0.0), abs(lean.distance))
            for lean in self._leans
        )
        swayed = sum(
            sway.amplitude * float(np.sin(2.0 * np.pi * sway.frequency * t + sway.phase))
            for sway in self._sways
        )
        return leant + swayed

    def distance(self, origins: Array, directions: Array, t: float) -> tuple[Array, Array, str]:
        """Meet rays, as `SkinSurface.distance` does."""
        return self._plane.distance(origins, directions, t)

    def cloud(self, t: float) -> Array:
        """Points of the skin that a camera sees at `t` [s], base frame [m], shape (M, 3)."""
        x = np.arange(-_HALF_HEIGHT, _HALF_HEIGHT + 1e-9, _SPACING)
        y = np.arange(-_HALF_WIDTH, _HALF_WIDTH + 1e-9, _SPACING)
        u, v = np.meshgrid(x, y)
        across = np.stack([u, v], -1).reshape(-1, 2) @ self.T_base_skin[:3, :2].T
        return self.T_base_skin[:3, 3] + across + self.shift(t) * self.outward
