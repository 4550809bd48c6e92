"""Where the arm is and how its joints are."""

from bathbot_scrub.rm65.controller.protocol import Frame, integer, joints_to_wire, pose_to_wire

from bathbot_bringup.sim.arm.commands.table import Desk, answer, command, state
from bathbot_bringup.sim.arm.controller.motion_plan import Motion
from bathbot_bringup.sim.arm.controller.push import CURRENT, TEMPERATURE, VOLTAGE

_TRAJECTORIES = {
    Motion.MOVE_J: "movej",
    Motion.MOVE_L: "movel",
    Motion.MOVE_C: "movec",
    Motion.MOVE_S: "moves",
}


@command("get_current_arm_state")
def _arm_state(desk: Desk, request: Frame) -> Frame:
    controller = desk.controller
    return state(
        "current_arm_state",
        arm_state={
            "joint": joints_to_wire(controller.dynamics.joints),
            "pose": pose_to_wire(controller.setup.tool_pose(controller.T_base_flange)),
            "err": [controller.health.error],
            "arm_err": controller.health.error,
            "sys_err": controller.system_error,
        },
    )


@command("get_joint_degree")
def _joint_degree(desk: Desk, request: Frame) -> Frame:
    return state("joint_degree", joint=joints_to_wire(desk.controller.dynamics.joints))


@command("get_arm_all_state")
def _all_state(desk: Desk, request: Frame) -> Frame:
    controller = desk.controller
    return state(
        "arm_all_state",
        all_state={
            "temperature": TEMPERATURE,
            "current": CURRENT,
            "voltage": VOLTAGE,
            "err_flag": controller.health.joint_codes,
            "en_flag": controller.health.joints_on,
            "err": [controller.health.error],
            "sys_err": controller.system_error,
        },
    )


@command("get_controller_state")
def _controller_state(desk: Desk, request: Frame) -> Frame:
    return state("controller_state", voltage=24000, current=1500, temperature=42000, err_flag=0)


@command("get_current_joint_temperature")
def _temperature(desk: Desk, request: Frame) -> Frame:
    return state("current_joint_temperature", joint_temperature=TEMPERATURE)


@command("get_current_joint_current")
def _current(desk: Desk, request: Frame) -> Frame:
    return state("current_joint_current", joint_current=CURRENT)


@command("get_current_joint_voltage")
def _voltage(desk: Desk, request: Frame) -> Frame:
    return state("current_joint_voltage", joint_voltage=VOLTAGE)


@command("get_joint_err_flag")
def _error_flags(desk: Desk, request: Frame) -> Frame:
    controller = desk.controller
    brakes = [int(not on) for on in controller.health.joints_on]  # 1: not released
    return state("joint_err_flag", err_flag=controller.health.joint_codes, brake_state=brakes)


@command("get_joint_en_state")
def _enabled(desk: Desk, request: Frame) -> Frame:
    return state("joint_en_state", en_state=desk.controller.health.joints_on)


@command("set_joint_clear_err", "joint_clear_err")
def _clear_joint(desk: Desk, request: Frame) -> Frame:
    desk.controller.health.clear_joint(integer(request, "joint_clear_err", 1, 6) - 1)
    return answer("set_joint_clear_err", joint_clear_err=True)


@command("clear_system_err", "clear_state")
def _clear(desk: Desk, request: Frame) -> Frame:
    desk.controller.health.clear()
    return answer("clear_system_err", clear_state=True)


@command("get_arm_current_trajectory")
def _trajectory(desk: Desk, request: Frame) -> Frame:
    controller = desk.controller
    running = controller.queue.current
    kind = _TRAJECTORIES.get(running.motion, "movej") if running else "none"
    if kind in ("none", "movej"):
        data = joints_to_wire(controller.dynamics.joints)
    else:
        data = pose_to_wire(controller.setup.tool_pose(controller.T_base_flange))
    return state("arm_current_trajectory", type=kind, data=data)
