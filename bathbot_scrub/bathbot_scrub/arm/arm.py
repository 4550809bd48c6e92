"""What an arm must tell: planner, clearance and driver take this and know no arm by name.

Frames are in the arm's base, base_link. J is the number of joints, L that of links, B that of branches: the
postures that hold one pose, at most. An arm is one folder with one class that has these members; `rm65` is
one.
"""

from typing import Protocol

import numpy as np
from bathbot_localize.arm.arm_shape import ArmShape
from bathbot_localize.arm.scrub_head import ScrubHead
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.joint_limits import JointLimits

Array = NDArray[np.float64]


class Arm(Protocol):
    """Kinematics, limits and shape of an arm that holds a scrub head."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the J joints in joint_states, from the base outwards."""

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the L frames of `link_frames` on TF, from base_link to the flange."""

    @property
    def tool(self) -> ScrubHead:
        """The scrub head on the flange; its frame is the last on TF."""

    @property
    def shape(self) -> ArmShape:
        """Capsules of links and head in their frames, and where the arm can work."""

    @property
    def moving_mass(self) -> float:
        """Of its parts that move, without the head [kg]."""

    @property
    def limits(self) -> JointLimits:
        """What the joints may do."""

    @property
    def home(self) -> Array:
        """Posture out of the camera's view [rad], shape (J,)."""

    def link_frames(self, joints: ArrayLike) -> Array:
        """Transforms T_base_link, shape (..., L, 4, 4), at joints [rad], shape (..., J)."""

    def flange(self, joints: ArrayLike) -> Array:
        """Transforms T_base_flange, shape (..., 4, 4), at joints [rad], shape (..., J)."""

    def head(self, joints: ArrayLike) -> Array:
        """Transforms T_base_head of the bristles' tip, shape (..., 4, 4), at joints [rad], shape (..., J)."""

    def solve_head(self, T_base_head: ArrayLike, limits: JointLimits | None = None) -> Array:
        """Joints [rad], shape (..., B, J), that hold the head at poses, shape (..., 4, 4); NaN where none.

        Args:
            T_base_head: Poses of the head.
            limits: Solutions outside are NaN; the arm's own if left out.

        Raises:
            InvalidPoseError: A pose is not finite or not rigid.
        """

    def why_unreachable(self, T_base_head: ArrayLike, limits: JointLimits, branch: int | None = None) -> str:
        """Say what keeps the head from a pose, (4, 4), on a branch or on all; empty when nothing does."""

    def roomy_limits(self, joints: ArrayLike) -> JointLimits:
        """Limits inside which a path can go on from joints [rad], shape (J,), wherever it turns.

        Narrower than `limits`: they leave room at the ends of the joints and keep off a stretched arm, on the
        branch of the joints given.
        """

    def supple(self, joints: ArrayLike) -> NDArray[np.bool_]:
        """Whether no joint would have to swing round nearby, shape (...), at joints [rad], shape (..., J)."""


class DrivenArm(Arm, Protocol):
    """An arm that a driver moves."""

    def description(self) -> str:
        """A URDF with the frames of `link_frames`, the scrub head and the capsules of `shape`."""
