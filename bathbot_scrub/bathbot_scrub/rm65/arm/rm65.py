"""The RM65 as an arm: what planner, mask, clearance and driver ask of any arm, answered for this one."""

from dataclasses import dataclass

import numpy as np
from bathbot_localize.arm.arm_shape import ArmShape
from numpy.typing import NDArray

from bathbot_scrub.rm65.arm.capsules import arm_shape
from bathbot_scrub.rm65.arm.kinematics import JOINT_NAMES, LINK_NAMES, Kinematics
from bathbot_scrub.rm65.arm.limits import HOME_DEG

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RM65(Kinematics):
    """One variant of the arm with a scrub head."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, from the base outwards."""
        return JOINT_NAMES

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the frames of `link_frames`."""
        return LINK_NAMES

    @property
    def shape(self) -> ArmShape:
        """Capsules of links and head, and the workspace."""
        return arm_shape(self.variant, self.tool)

    @property
    def home(self) -> Array:
        """Folded posture [rad], shape (6,)."""
        return np.radians(HOME_DEG)
