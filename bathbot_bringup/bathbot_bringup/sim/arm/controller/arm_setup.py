"""Which arm is emulated, and what a client may set on it and read back: limits, poses, frames, modes."""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse
from bathbot_localize.arm.scrub_head import SCRUB_HEAD, ScrubHead
from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.arm.joint_limits import JointLimits
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.controller.protocol import pose_from_wire
from numpy.typing import NDArray

from bathbot_bringup.sim.brush import Brush

Array = NDArray[np.float64]
_MOST_FRAMES = 10  # of each sort
_LONGEST_NAME = 10  # [bytes], as the vendor's software says
DRIVE_LIMITS = replace(RM65_LIMITS, acceleration=np.radians([600.0] * 6))  # what the joints can do


@dataclass(frozen=True, slots=True)
class Arm:
    """Which arm is emulated."""

    kinematics: RM65
    limits: JointLimits
    brush: Brush
    generation: int = 3


@dataclass(slots=True)
class Speeds:
    """Largest speeds and accelerations of the tool; also what v = 100 means."""

    line: float = 0.25  # [m/s]
    line_acceleration: float = 1.6  # [m/s^2]
    angular: float = 0.6  # [rad/s]
    angular_acceleration: float = 4.0  # [rad/s^2]


class ToolFrame(NamedTuple):
    """A tool, in the units of the wire."""

    pose: tuple[int, ...] = (0,) * 6  # of the tool on the flange
    payload: int = 0  # [g]
    centre: tuple[int, ...] = (0, 0, 0)  # of gravity, on the flange [0.001 mm]


class Frames:
    """Named frames of one sort, one of them in use."""

    def __init__(self, default: str, entry: ToolFrame) -> None:
        """Begin with one frame that can be neither changed nor deleted.

        `T` is the transform of the frame in use, (4, 4).
        """
        self._default, self._entries = default, {default: entry}
        self.change(default)

    @property
    def names(self) -> list[str]:
        """Names of all."""
        return list(self._entries)

    def get(self, name: str) -> ToolFrame:
        """Look up a frame.

        Raises:
            ProtocolError: When there is none of this name.
        """
        if name not in self._entries:
            raise ProtocolError(f"no frame {name!r}; there are {', '.join(self._entries)}")
        return self._entries[name]

    def add(self, name: str, entry: ToolFrame) -> None:
        """Enter a new frame.

        Raises:
            ProtocolError: On a name that is taken or none, or when there are too many.
        """
        if not name or len(name.encode(errors="replace")) > _LONGEST_NAME or name in self._entries:
            raise ProtocolError(f"a new frame needs a name of 1 to {_LONGEST_NAME} bytes, got {name!r:.40}")
        if len(self._entries) >= _MOST_FRAMES:
            raise ProtocolError(f"there are {_MOST_FRAMES} frames already; delete one")
        self._entries[name] = entry

    def update(self, name: str, entry: ToolFrame) -> None:
        """Change a frame.

        Raises:
            ProtocolError: When there is none of this name, or it is the default.
        """
        self._check_ours(name)
        self._entries[name] = entry
        self.change(self.current)

    def delete(self, name: str) -> None:
        """Remove a frame that is not in use.

        Raises:
            ProtocolError: When there is none of this name, or it is the default or in use.
        """
        self._check_ours(name)
        if name == self.current:
            raise ProtocolError(f"frame {name!r} is in use; change to another first")
        del self._entries[name]

    def change(self, name: str) -> None:
        """Use another frame.

        Raises:
            ProtocolError: When there is none of this name.
        """
        self.current, self.T = name, pose_from_wire(self.get(name).pose)
        self.T_inverse = inverse(self.T)

    def _check_ours(self, name: str) -> None:
        self.get(name)
        if name == self._default:
            raise ProtocolError(f"frame {name!r} is the controller's own")


def mounted(head: ScrubHead) -> ToolFrame:
    """The weight of a scrub head as the controller keeps it, in g and um."""
    return ToolFrame(payload=round(1e3 * head.mass), centre=(0, 0, round(1e6 * head.mass_centre)))


@dataclass(slots=True)
class ArmSetup:
    """The settings of one controller. Not thread-safe, like the controller."""

    limits: JointLimits = RM65_LIMITS
    speeds: Speeds = field(default_factory=Speeds)
    tools: Frames = field(default_factory=lambda: Frames("Arm_Tip", mounted(SCRUB_HEAD)))
    works: Frames = field(default_factory=lambda: Frames("Base", ToolFrame()))
    install_pose: tuple[int, ...] = (0, 0, 0)  # [deg]
    init_pose: tuple[int, ...] = (0,) * 6  # joints on the wire
    collision_stage: int = 0  # 0: off
    run_mode: int = 1  # 0 simulation, 1 real
    self_collision: bool = False

    def tool_pose(self, T_base_flange: Array) -> Array:
        """Pose of the tool in the work frame, (4, 4), of a pose of the flange in the base."""
        return self.works.T_inverse @ T_base_flange @ self.tools.T

    def flange_pose(self, T_work_tool: Array) -> Array:
        """Pose of the flange in the base, (4, 4), of a pose of the tool in the work frame."""
        return self.works.T @ T_work_tool @ self.tools.T_inverse
