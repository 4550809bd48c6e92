"""The scrub head: a round soft brush on a handle, for mask, planner, driver, simulator and report.

Its frame has the origin at the tip of the unbent bristles, z into the skin and y along the travel; the
flange lies `length` behind the tip along z (d of Eqs. (15)-(17)).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_from
from numpy.typing import NDArray

from bathbot_localize.arm.arm_shape import ArmCapsule

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ScrubHead:
    """Geometry and mass of a scrub head; how stiff its bristles are is a matter of forces, not of shape."""

    length: float = 0.10  # [m] from the flange to the tip of the bristles
    brush_radius: float = 0.025  # [m]
    brush_height: float = 0.040  # [m] of the brush over its handle
    give: float = 0.010  # [m] by which the bristles bend before they are stiff
    handle_radius: float = 0.020  # [m]
    mass: float = 0.35  # [kg] brush and motor
    mass_centre: float = 0.05  # [m] from the flange along z
    frame: str = "scrub_head"  # name of its frame

    @cached_property
    def T_flange_head(self) -> Array:
        """Maps head to flange coordinates, shape (4, 4), read-only."""
        return _along_z(self.length)

    @cached_property
    def T_head_flange(self) -> Array:
        """Maps flange to head coordinates, shape (4, 4), read-only."""
        return _along_z(-self.length)

    @property
    def capsules(self) -> tuple[ArmCapsule, ...]:
        """Handle and brush; the brush's sphere ends at the tip of the unbent bristles."""
        joint, middle = (0.0, 0.0, -self.brush_height), (0.0, 0.0, -self.brush_radius)
        return (
            ArmCapsule(self.frame, (0.0, 0.0, -self.length), joint, self.handle_radius),
            ArmCapsule(self.frame, joint, middle, self.brush_radius),
        )


def _along_z(distance: float) -> Array:
    T = transform_from(translation=(0.0, 0.0, distance))
    T.setflags(write=False)
    return T


SCRUB_HEAD = ScrubHead()
"""The one that is mounted."""
