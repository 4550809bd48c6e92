"""An arm for tests that is no RM65: three slides carry a wrist, Rz(q4) Ry(q5) Rz(q6), and that the flange.

Its slides are joints like the others, in [m]. The hand reaches forwards; behind it, along -x, lies a boom.
"""

from dataclasses import dataclass, replace

import numpy as np
from bathbot_localize.arm.arm_shape import ArmCapsule, ArmShape
from bathbot_localize.arm.scrub_head import SCRUB_HEAD, ScrubHead
from bathbot_localize.surface.workspace import Workspace
from bathbot_scrub.arm.joint_limits import JointLimits
from scipy.spatial.transform import Rotation

BOOM = ArmCapsule("slide_z", (-0.60, 0.0, 0.0), (-0.10, 0.0, 0.0), 0.04)
HAND = ArmCapsule("hand", (0.0, 0.0, -0.04), (0.0, 0.0, -0.04), 0.03)
FOOT = ArmCapsule("base_link", (0.0, 0.0, -0.5), (0.0, 0.0, -0.3), 0.10)
LIMITS = JointLimits(
    lower=np.array([0.2, -0.4, -0.4, -1.5, -3.0, -6.2]),
    upper=np.array([1.0, 0.4, 0.4, 1.5, 3.0, 6.2]),
    speed=np.full(6, 2.0),
    acceleration=np.full(6, 4.0),
    jerk=np.full(6, 40.0),
)
_OFF_POLE = 0.1  # sine of q5 below which q4 and q6 turn about one axis


@dataclass(frozen=True)
class GantryArm:
    """Implements `bathbot_scrub.arm.arm.Arm`."""

    tool: ScrubHead = SCRUB_HEAD
    limits: JointLimits = LIMITS
    joint_names: tuple[str, ...] = ("x", "y", "z", "yaw", "pitch", "roll")
    moving_mass: float = 12.0
    link_names: tuple[str, ...] = ("base_link", "slide_x", "slide_y", "slide_z", "yaw", "pitch", "hand")

    @property
    def shape(self):
        """A boom on a foot, a hand and the head."""
        workspace = Workspace((0.0, 0.0, 0.0), 0.2, 1.0, self.tool.length, 1.5)
        return ArmShape((FOOT, BOOM, HAND, *self.tool.capsules), "hand", ("base_link",), workspace)

    @property
    def home(self):
        """Drawn back, the head forwards."""
        return np.array([0.2, 0.0, 0.0, 0.0, np.pi / 2, 0.0])

    def link_frames(self, joints):
        """T_base_link of the seven links, shape (..., 7, 4, 4)."""
        joints = np.asarray(joints, dtype=float)
        frames = np.broadcast_to(np.eye(4), (*joints.shape[:-1], 7, 4, 4)).copy()
        for slide in range(3):
            frames[..., slide + 1 :, slide, 3] = joints[..., slide, None]
        flat = joints.reshape(-1, 6)
        for link, axes in ((4, "Z"), (5, "ZY"), (6, "ZYZ")):
            turns = Rotation.from_euler(axes, flat[:, 3 : 3 + len(axes)]).as_matrix()
            frames[..., link, :3, :3] = turns.reshape(*joints.shape[:-1], 3, 3)
        return frames

    def flange(self, joints):
        """T_base_flange, shape (..., 4, 4)."""
        return self.link_frames(joints)[..., 6, :, :]

    def head(self, joints):
        """T_base_head, shape (..., 4, 4)."""
        return self.flange(joints) @ self.tool.T_flange_head

    def solve_head(self, T_base_head, limits=None):
        """Both ways to bend the wrist, shape (..., 2, 6), NaN outside the limits."""
        flange = np.asarray(T_base_head, dtype=float) @ self.tool.T_head_flange
        turns = Rotation.from_matrix(flange[..., :3, :3].reshape(-1, 3, 3)).as_euler("ZYZ")
        turns = turns.reshape(*flange.shape[:-2], 3)
        other = np.stack([_turned(turns[..., 0]), -turns[..., 1], _turned(turns[..., 2])], axis=-1)
        wrist = np.stack([turns, other], axis=-2)
        slides = np.broadcast_to(flange[..., None, :3, 3], wrist.shape)
        joints = np.concatenate([slides, wrist], axis=-1)
        return np.where((limits or self.limits).contain(joints)[..., None], joints, np.nan)

    def why_unreachable(self, T_base_head, limits, branch=None):
        """The place of the flange that no slide reaches, or that the wrist does not bend so."""
        if np.isfinite(self.solve_head(T_base_head, limits)).any():
            return ""
        return f"the slides or the wrist end before {np.round(np.asarray(T_base_head)[:3, 3], 3)} m"

    def roomy_limits(self, joints):
        """5 cm and 3 degrees off all ends."""
        return replace(self.limits, lower=self.limits.lower + 0.05, upper=self.limits.upper - 0.05)

    def supple(self, joints):
        """Off the pole of the wrist."""
        return np.abs(np.sin(np.asarray(joints)[..., 4])) > _OFF_POLE


def _turned(angle):
    return np.where(angle > 0.0, angle - np.pi, angle + np.pi)
