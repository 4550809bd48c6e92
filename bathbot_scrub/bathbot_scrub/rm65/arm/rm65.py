"""The RM65 as an `Arm`: what planner, mask, clearance and driver ask of any arm, answered for this one."""

from dataclasses import dataclass, replace

import numpy as np
from bathbot_localize.arm.arm_shape import ArmShape
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.joint_limits import JointLimits
from bathbot_scrub.rm65.arm.capsules import arm_shape
from bathbot_scrub.rm65.arm.inverse_kinematics import solve_head, why_unreachable
from bathbot_scrub.rm65.arm.kinematics import JOINT_NAMES, LINK_NAMES, Kinematics
from bathbot_scrub.rm65.arm.limits import HOME_DEG, RM65_LIMITS
from bathbot_scrub.rm65.arm.urdf import moving_mass, urdf

Array = NDArray[np.float64]
_OFF_LIMITS = np.radians(5.0)  # [rad] from the limit of a joint
_OFF_STRETCHED = np.radians(30.0)  # [rad] of the elbow: the wrist's centre keeps 16 mm to go
_OFF_STRAIGHT = np.sin(np.radians(4.0))  # of joint 5


@dataclass(frozen=True)
class RM65(Kinematics):
    """One variant of the arm with a scrub head."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """joint1 ... joint6."""
        return JOINT_NAMES

    @property
    def link_names(self) -> tuple[str, ...]:
        """base_link, Link1 ... Link6."""
        return LINK_NAMES

    @property
    def shape(self) -> ArmShape:
        """Capsules of links and head, and the workspace."""
        return arm_shape(self.variant, self.tool)

    @property
    def moving_mass(self) -> float:
        """Of its links that move [kg]."""
        return moving_mass(self.variant)

    @property
    def limits(self) -> JointLimits:
        """Those of the data sheet, with gentler accelerations."""
        return RM65_LIMITS

    @property
    def home(self) -> Array:
        """Folded posture [rad], shape (6,)."""
        return np.radians(HOME_DEG)

    def solve_head(self, T_base_head: ArrayLike, limits: JointLimits | None = None) -> Array:
        """Joints [rad], shape (..., 8, 6), that hold the head at poses (..., 4, 4); NaN where none."""
        return solve_head(self, T_base_head, limits or RM65_LIMITS)

    def why_unreachable(self, T_base_head: ArrayLike, limits: JointLimits, branch: int | None = None) -> str:
        """Say what keeps the head from a pose, (4, 4), on a branch or on all; empty when nothing does."""
        return why_unreachable(self, T_base_head, limits, branch)

    def roomy_limits(self, joints: ArrayLike) -> JointLimits:
        """Limits off the data sheet's and off the stretched elbow, bent as at joints, (6,) [rad].

        Where the arm is stretched, a few degrees of the skin's normal decide whether it reaches.
        """
        lower, upper = RM65_LIMITS.lower + _OFF_LIMITS, RM65_LIMITS.upper - _OFF_LIMITS
        if np.asarray(joints, dtype=float)[2] < 0.0:
            upper[2] = -_OFF_STRETCHED
        else:
            lower[2] = _OFF_STRETCHED
        return replace(RM65_LIMITS, lower=lower, upper=upper)

    def supple(self, joints: ArrayLike) -> NDArray[np.bool_]:
        """Where the wrist is bent, shape (...), at joints (..., 6); near a straight one joint 4 swings."""
        return np.abs(np.sin(np.asarray(joints, dtype=float)[..., 4])) > _OFF_STRAIGHT

    def description(self) -> str:
        """A URDF with the scrub head."""
        return urdf(self.variant, self.tool)
