"""What a controller says about itself: versions, kinematics, run time."""

from bathbot_scrub.rm65.arm.kinematics import BASE_HEIGHT, FOREARM, UPPER_ARM
from bathbot_scrub.rm65.controller.protocol import Frame, joints_to_wire

from bathbot_bringup.sim.arm.commands.table import Desk, answer, command, state

_FIRMWARE, _BUILT = "V1.7.0", "2024/09/01 00:00:00"
_PART_FIRMWARE = {3: 531, 4: "V5.3.1"}  # of joints and tool: a number, later a text


@command("get_arm_software_info")
def _software(desk: Desk, request: Frame) -> Frame:
    info = {
        "Product_version": f"RM65-{desk.controller.arm.kinematics.variant}I",
        "algorithm_info": {"version": "1.4.3"},
        "ctrl_info": {"build_time": _BUILT, "version": _FIRMWARE},
        "dynamic_info": {"model_version": "2"},
        "plan_info": {"build_time": _BUILT, "version": _FIRMWARE},
    }
    if desk.controller.arm.generation >= 4:
        info["program_info"] = {"build_time": _BUILT, "version": _FIRMWARE}
        info["communication_info"] = {"build_time": _BUILT, "version": _FIRMWARE}
        info["robot_controller_version"] = "4.0"
    return answer("arm_software_info", **info)


@command("get_joint_software_version")
def _joint_software(desk: Desk, request: Frame) -> Frame:
    return state("joint_software_version", version=[_PART_FIRMWARE[desk.controller.arm.generation]] * 6)


@command("get_tool_software_version")
def _tool_software(desk: Desk, request: Frame) -> Frame:
    return state("tool_software_version", version=_PART_FIRMWARE[desk.controller.arm.generation])


@command("get_DH_data")
def _dh_data(desk: Desk, request: Frame) -> Frame:
    rows = [
        (0, 0.0, BASE_HEIGHT, 0),
        (90, 0.0, 0.0, 90),
        (0, UPPER_ARM, 0.0, 90),
        (90, 0.0, FOREARM, 0),
        (-90, 0.0, 0.0, 0),
        (90, 0.0, desk.controller.arm.kinematics.flange_offset, 0),
    ]
    return answer(
        "get_DH_data",
        **{
            f"joint_{i + 1}": [alpha * 1000, round(a * 1e6), round(d * 1e6), offset * 1000]
            for i, (alpha, a, d, offset) in enumerate(rows)
        },
    )


@command("get_system_runtime")
def _runtime(desk: Desk, request: Frame) -> Frame:
    minutes, seconds = divmod(int(desk.clock() - desk.begun), 60)
    hours, minutes = divmod(minutes, 60)
    days, hours = divmod(hours, 24)
    return answer("get_system_runtime", day=days, hour=hours, min=minutes, sec=seconds)


@command("get_joint_odom")
def _odometer(desk: Desk, request: Frame) -> Frame:
    return answer("get_joint_odom", odom=joints_to_wire(desk.controller.dynamics.travelled))
