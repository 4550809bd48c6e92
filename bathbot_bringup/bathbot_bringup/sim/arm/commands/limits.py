"""Limits of joints and tool: asked for and set, within what the drives can do."""

from dataclasses import replace

import numpy as np
from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.rm65.controller.protocol import Frame, integer, integers
from numpy.typing import NDArray

from bathbot_bringup.sim.arm.commands.table import Desk, answer, command, state
from bathbot_bringup.sim.arm.controller.arm_setup import DRIVE_LIMITS, Speeds

_SPEED_UNIT = np.radians(6.0) / 1000.0  # 0.001 RPM in [rad/s], and 0.001 RPM/s in [rad/s^2]
_ANGLE_UNIT = np.radians(1.0) / 1000.0
_JOINT = {  # name on the wire: field of JointLimits, key of the values, unit
    "max_speed": ("speed", "joint_speed", _SPEED_UNIT),
    "max_acc": ("acceleration", "joint_acc", _SPEED_UNIT),
    "min_pos": ("lower", "min_pos", _ANGLE_UNIT),
    "max_pos": ("upper", "max_pos", _ANGLE_UNIT),
}
_TOOL = {  # name on the wire: field of Speeds, key of the value
    "line_speed": ("line", "arm_line_speed"),
    "line_acc": ("line_acceleration", "arm_line_acc"),
    "angular_speed": ("angular", "arm_angular_speed"),
    "angular_acc": ("angular_acceleration", "arm_angular_acc"),
}
_FASTEST = {"line": 1.8, "line_acceleration": 10.0, "angular": 3.5, "angular_acceleration": 20.0}  # SI


def _on_wire(values: NDArray[np.float64], unit: float) -> list[int]:
    return [round(float(value) / unit) for value in values]


def _enter_joint_limit(name: str, field: str, key: str, unit: float) -> None:
    """Enter the three commands of one limit of the joints."""

    @command(f"get_joint_{name}")
    def ask(desk: Desk, request: Frame) -> Frame:
        return state(f"joint_{name}", **{key: _on_wire(getattr(desk.controller.setup.limits, field), unit)})

    @command(f"get_joint_drive_{name}")
    def ask_drive(desk: Desk, request: Frame) -> Frame:
        return answer(f"get_joint_drive_{name}", **{key: _on_wire(getattr(DRIVE_LIMITS, field), unit)})

    @command(f"set_joint_{name}", f"joint_{name}")
    def set_one(desk: Desk, request: Frame) -> Frame:
        joint, value = integers(request, f"joint_{name}", 2)
        setup = desk.controller.setup
        if joint not in range(1, 7):
            raise ProtocolError(f"joint must be 1 to 6, got {joint}")
        index, wanted = int(joint) - 1, float(value) * unit
        _check_joint_limit(field, index, wanted)
        values = np.array(getattr(setup.limits, field))
        values[index] = wanted
        changed = replace(setup.limits, **{field: values})
        if not (changed.lower < changed.upper).all():
            raise ProtocolError("the lower limit must stay below the upper one")
        setup.limits = changed
        return answer(f"set_joint_{name}", **{f"joint_{name}": True})


def _check_joint_limit(field: str, joint: int, wanted: float) -> None:
    """Refuse what the drive of a joint, from 0, cannot do; `wanted` in SI units."""
    lowest, highest = float(DRIVE_LIMITS.lower[joint]), float(DRIVE_LIMITS.upper[joint])
    if field in ("speed", "acceleration"):
        lowest, highest = _SPEED_UNIT, float(getattr(DRIVE_LIMITS, field)[joint])
    if not lowest - 1e-9 <= wanted <= highest + 1e-9:
        raise ProtocolError(
            f"{field} {wanted:.4f} of joint {joint + 1} is outside {lowest:.4f} to {highest:.4f}"
        )


def _enter_tool_limit(name: str, field: str, key: str) -> None:
    """Enter the two commands of one limit of the tool."""

    @command(f"get_arm_max_{name}")
    def ask(desk: Desk, request: Frame) -> Frame:
        value = round(getattr(desk.controller.setup.speeds, field) * 1e3)
        return state(f"arm_max_{name}", **{key: value})

    @command(f"set_arm_max_{name}", key)
    def set_one(desk: Desk, request: Frame) -> Frame:
        value = integer(request, key, 1, round(_FASTEST[field] * 1e3))
        setattr(desk.controller.setup.speeds, field, value * 1e-3)
        return answer(f"set_arm_max_{name}", **{key: True})


for _name, _entry in _JOINT.items():
    _enter_joint_limit(_name, *_entry)
for _name, _tool_entry in _TOOL.items():
    _enter_tool_limit(_name, *_tool_entry)


@command("set_arm_init", "arm_init")
def _defaults(desk: Desk, request: Frame) -> Frame:
    desk.controller.setup.speeds = Speeds()
    return answer("set_arm_init", arm_init=True)
