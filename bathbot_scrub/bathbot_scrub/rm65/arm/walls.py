"""Planes that bound the space in which the arm may move: floor, walls, glass."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bathbot_scrub.arm.errors import ArmSettingsError


class Wall(NamedTuple):
    """Points x with normal . x >= offset [m] are free, base frame."""

    normal: tuple[float, float, float]  # of unit length, into the room
    offset: float

    @property
    def name(self) -> str:
        """How messages call it."""
        return "the wall at ({:g}, {:g}, {:g}) x = {:g} m".format(*self.normal, self.offset)


def walls_from(numbers: Sequence[float]) -> tuple[Wall, ...]:
    """Walls of a flat list: four numbers each, the normal and the offset.

    Raises:
        ArmSettingsError: When the list is none of walls, or a wall stands in the arm's shoulder.
    """
    values = np.asarray(numbers, dtype=float)
    if values.size % 4 or not np.isfinite(values).all():
        raise ArmSettingsError(f"walls must be four finite numbers each, got {list(numbers)}")
    walls = []
    for *normal, offset in values.reshape(-1, 4):
        length = float(np.linalg.norm(normal))
        if length < 1e-6:
            raise ArmSettingsError(f"a wall needs a normal that is not zero, got {list(numbers)}")
        if offset > 0.0:
            raise ArmSettingsError(
                f"a wall at {offset} m along its normal leaves out the base at 0; turn it round"
            )
        walls.append(Wall(tuple(float(v) / length for v in normal), float(offset) / length))
    return tuple(walls)
