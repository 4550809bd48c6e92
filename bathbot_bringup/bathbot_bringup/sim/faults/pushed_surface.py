"""A surface that is pushed about as a whole, and the faults that push it: towards the scrub head, or away."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.brush import SkinSurface
from bathbot_bringup.sim.faults.lasting_fault import LastingFault

Array = NDArray[np.float64]
FARTHEST = 0.3  # [m] from where it was
_BACK = 0.06  # [m] behind the tip where the skin is looked for


class PushedSurface:
    """Any surface, moved by an offset; one thread moves and asks it."""

    def __init__(self, surface: SkinSurface) -> None:
        """Begin where `surface` is."""
        self._surface = surface
        self.offset = np.zeros(3)  # [m] in the base frame

    def distance(self, origins: Array, directions: Array, t: float) -> tuple[Array, Array, str]:
        """Meet rays, as `SkinSurface.distance` does."""
        return self._surface.distance(origins - self.offset, directions, t)

    def towards(self, T_base_head: Array, t: float, pressed: bool) -> Array:
        """Unit vector that leads the body to the head, shape (3,).

        The outward normal of the skin under the middle of the brush where it is pressed, else against the
        head's approach axis.
        """
        approach = T_base_head[:3, 2]
        if pressed:
            origin = T_base_head[:3, 3] - _BACK * approach
            distances, normals, _ = self.distance(origin[None], approach[None], t)
            if np.isfinite(distances[0]) and np.linalg.norm(normals[0]) > 0.5:
                return normals[0] / np.linalg.norm(normals[0])
        return -approach

    def move(self, step: Array) -> None:
        """Move on by `step` [m], shape (3,), unless that is too far from the beginning."""
        moved = self.offset + step
        if np.linalg.norm(moved) <= FARTHEST:
            self.offset = moved

    def put_back(self) -> None:
        """Return to the beginning at once."""
        self.offset = np.zeros(3)


class BodyStep(NamedTuple):
    """What the body is like in one step of the controller."""

    T_base_head: Array  # (4, 4)
    t: float  # time of the body [s]
    pressed: bool  # whether the brush touches it
    period: float  # of the step [s]


def coming(fault: LastingFault, surface: PushedSurface, step: BodyStep) -> None:
    """Move the body towards the head, its value in m/s, in the direction in which the fault began."""
    _move(fault, surface, step, 1.0)


def leaving(fault: LastingFault, surface: PushedSurface, step: BodyStep) -> None:
    """Move the body away from the head, its value in m/s, against the direction to where it was."""
    _move(fault, surface, step, -1.0)


def _move(fault: LastingFault, surface: PushedSurface, step: BodyStep, sign: float) -> None:
    if "towards" not in fault.memory:
        fault.memory["towards"] = surface.towards(step.T_base_head, step.t, step.pressed)
    surface.move(sign * fault.value * step.period * fault.memory["towards"])
