"""The controller's command table: one function per command of the protocol.

Each takes the controller and the request and gives the reply, or nothing where the protocol answers
nothing. Wire units are turned into SI here and nowhere else.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from bathbot_scrub.rm65.errors import ArmError, ProtocolError
from bathbot_scrub.rm65.kinematics import BASE_HEIGHT, FOREARM, UPPER_ARM
from bathbot_scrub.rm65.protocol import Frame, integer, joints_to_wire, pose_to_wire

from bathbot_bringup.sim.controller import Controller, Motion
from bathbot_bringup.sim.push import PushSettings, wire_wrench
from bathbot_bringup.sim.trace import Trace

_SPEED_UNIT = np.radians(6.0) / 1000.0  # 0.001 RPM in [rad/s], and 0.001 RPM/s in [rad/s^2]
_FIRMWARE = "V1.7.0"


@dataclass(slots=True)
class Desk:
    """What a command may look at and change."""

    controller: Controller
    push: PushSettings = field(default_factory=PushSettings)
    trace: Trace = field(default_factory=Trace)


Command = Callable[[Desk, Frame], Frame | None]
COMMANDS: dict[str, Command] = {}


def command(name: str) -> Callable[[Command], Command]:
    """Enter a function into the table under the protocol's name."""

    def enter(function: Command) -> Command:
        COMMANDS[name] = function
        return function

    return enter


def reply(desk: Desk, request: Frame) -> Frame | None:
    """Answer one request; nothing where the protocol answers nothing.

    Raises:
        ProtocolError: When the request lacks a command name.
    """
    name = request.get("command")
    if not isinstance(name, str):
        raise ProtocolError(f"request without a command: {str(request)[:80]}")
    function = COMMANDS.get(name)
    if function is None:
        return {"command": name[:60], "receive_state": False}  # what firmware says is not published
    try:
        return function(desk, request)
    except (ProtocolError, ArmError):
        return {"command": name, "receive_state": False} if name not in SILENT else None


SILENT = frozenset({"movej_canfd"})


def _state(name: str, **values: Any) -> Frame:
    return {"state": name, **values}


def _answer(name: str, **values: Any) -> Frame:
    return {"command": name, **values}


@command("get_arm_software_info")
def _software_info(desk: Desk, request: Frame) -> Frame:
    variant = desk.controller.arm.kinematics.variant
    info = {
        "Product_version": f"RM65-{variant}I",
        "algorithm_info": {"version": "1.4.3"},
        "ctrl_info": {"build_time": "2024/09/01 00:00:00", "version": _FIRMWARE},
        "dynamic_info": {"model_version": "2"},
        "plan_info": {"build_time": "2024/09/01 00:00:00", "version": _FIRMWARE},
    }
    if desk.controller.arm.generation == 4:
        info["robot_controller_version"] = "4.0"
    return _answer("arm_software_info", **info)


@command("get_current_arm_state")
def _arm_state(desk: Desk, request: Frame) -> Frame:
    controller = desk.controller
    return _state(
        "current_arm_state",
        arm_state={
            "joint": joints_to_wire(controller.dynamics.joints),
            "pose": pose_to_wire(controller.T_base_flange),
            "err": [controller.error],
            "arm_err": controller.error,
            "sys_err": controller.system_error,
        },
    )


@command("get_joint_degree")
def _joint_degree(desk: Desk, request: Frame) -> Frame:
    return _state("joint_degree", joint=joints_to_wire(desk.controller.dynamics.joints))


@command("get_arm_current_trajectory")
def _trajectory(desk: Desk, request: Frame) -> Frame:
    controller = desk.controller
    kinds = {Motion.MOVE_J: "movej", Motion.MOVE_L: "movel"}
    kind = kinds.get(controller.motion, "movej") if controller.busy else "none"
    return _state("arm_current_trajectory", type=kind, data=joints_to_wire(controller.dynamics.joints))


@command("get_realtime_push")
def _get_push(desk: Desk, request: Frame) -> Frame:
    push = desk.push
    custom = dict.fromkeys(("joint_speed", "lift_state", "expand_state", "arm_current_status"), True)
    return _answer(
        "get_realtime_push",
        cycle=push.cycle,
        enable=push.enable,
        port=push.port,
        ip=push.ip,
        force_coordinate=push.force_coordinate,
        custom=custom,
    )


@command("set_realtime_push")
def _set_push(desk: Desk, request: Frame) -> Frame:
    push = desk.push
    changes: dict[str, Any] = {}
    if "cycle" in request:
        changes["cycle"] = integer(request, "cycle", 1, 10_000)
    if "port" in request:
        changes["port"] = integer(request, "port", 1, 65535)
    if "force_coordinate" in request:
        changes["force_coordinate"] = integer(request, "force_coordinate", 0, 2)
    if isinstance(request.get("enable"), bool):
        changes["enable"] = request["enable"]
    if isinstance(request.get("ip"), str):
        changes["ip"] = request["ip"][:64]
    desk.push = replace(push, **changes)
    return _answer("set_realtime_push", state=True)


@command("get_current_work_frame")
def _work_frame(desk: Desk, request: Frame) -> Frame:
    return _state("current_work_frame", frame_name="Base", pose=[0] * 6)


@command("get_current_tool_frame")
def _tool_frame(desk: Desk, request: Frame) -> Frame:
    return _state(
        "current_tool_frame", tool_name="Arm_Tip", pose=[0] * 6, payload=350, position=[0, 0, 50000]
    )


@command("get_install_pose")
def _install_pose(desk: Desk, request: Frame) -> Frame:
    return _state("install_pose", pose=[0, 0, 0])


@command("get_joint_min_pos")
def _min_pos(desk: Desk, request: Frame) -> Frame:
    return _state("joint_min_pos", min_pos=joints_to_wire(desk.controller.arm.limits.lower))


@command("get_joint_max_pos")
def _max_pos(desk: Desk, request: Frame) -> Frame:
    return _state("joint_max_pos", max_pos=joints_to_wire(desk.controller.arm.limits.upper))


@command("get_joint_max_acc")
def _max_acc(desk: Desk, request: Frame) -> Frame:
    return _state("joint_max_acc", joint_acc=[100_000] * 6)


@command("get_joint_max_speed")
def _max_speed(desk: Desk, request: Frame) -> Frame:
    speeds = [round(float(v) / _SPEED_UNIT) for v in desk.controller.arm.limits.speed]
    return _state("joint_max_speed", joint_speed=speeds)


@command("get_DH_data")
def _dh_data(desk: Desk, request: Frame) -> Frame:
    d6 = desk.controller.arm.kinematics.flange_offset
    rows = [
        (0, 0.0, BASE_HEIGHT, 0),
        (90, 0.0, 0.0, 90),
        (0, UPPER_ARM, 0.0, 90),
        (90, 0.0, FOREARM, 0),
        (-90, 0.0, 0.0, 0),
        (90, 0.0, d6, 0),
    ]
    return _answer(
        "get_DH_data",
        **{
            f"joint_{i + 1}": [alpha * 1000, round(a * 1e6), round(d * 1e6), offset * 1000]
            for i, (alpha, a, d, offset) in enumerate(rows)
        },
    )


@command("get_force_data")
def _force_data(desk: Desk, request: Frame) -> Frame:
    raw, zero = (wire_wrench(wrench) for wrench in desk.controller.sensor.reading)
    turned = desk.controller.T_base_flange[:3, :3]
    value = desk.controller.sensor.reading.zero
    work = wire_wrench(np.concatenate([turned @ value[:3], turned @ value[3:]]))
    return _answer(
        "get_force_data",
        force_data=raw,
        zero_force_data=zero,
        work_zero_force_data=work,
        tool_zero_force_data=zero,
    )


@command("clear_force_data")
def _clear_force(desk: Desk, request: Frame) -> Frame:
    desk.controller.sensor.clear()
    return _answer("clear_force_data", clear_state=True)


@command("clear_system_err")
def _clear_errors(desk: Desk, request: Frame) -> Frame:
    desk.controller.clear_errors()
    return _answer("clear_system_err", clear_state=True)


@command("get_arm_power_state")
def _power_state(desk: Desk, request: Frame) -> Frame:
    return _state("arm_power_state", power_state=int(desk.controller.power))


@command("set_arm_power")
def _set_power(desk: Desk, request: Frame) -> Frame:
    desk.controller.power = bool(integer(request, "arm_power", 0, 1))
    return _answer("set_arm_power", arm_power=True)
