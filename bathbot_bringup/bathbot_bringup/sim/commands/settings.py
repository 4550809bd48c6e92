"""Settings that are kept and told again: mounting, initial posture, collision stage, modes."""

from bathbot_scrub.rm65.protocol import Frame, integer, integers, joints_from_wire

from bathbot_bringup.sim.commands.table import Desk, answer, command, flag, state


@command("get_install_pose")
def _install(desk: Desk, request: Frame) -> Frame:
    return state("install_pose", pose=list(desk.controller.setup.install_pose))


@command("set_install_pose", "set_state")
def _set_install(desk: Desk, request: Frame) -> Frame:
    desk.controller.setup.install_pose = tuple(int(angle) for angle in integers(request, "pose", 3))
    return answer("set_install_pose", set_state=True)


@command("get_init_pose")
def _initial(desk: Desk, request: Frame) -> Frame:
    return state("arm_init_pose", init_pose=list(desk.controller.setup.init_pose))


@command("set_init_pose", "init_pose")
def _set_initial(desk: Desk, request: Frame) -> Frame:
    values = integers(request, "init_pose", 6)
    desk.controller.setup.limits.check(joints_from_wire(values))
    desk.controller.setup.init_pose = tuple(int(value) for value in values)
    return answer("set_init_pose", init_pose=True)


@command("get_collision_stage")
def _stage(desk: Desk, request: Frame) -> Frame:
    return state("get_collision_stage", collision_stage=desk.controller.setup.collision_stage)


@command("set_collision_stage", "collision_state")
def _set_stage(desk: Desk, request: Frame) -> Frame:
    desk.controller.setup.collision_stage = integer(request, "collision_stage", 0, 8)
    return answer("set_collision_stage", collision_state=True)


@command("get_arm_run_mode")
def _mode(desk: Desk, request: Frame) -> Frame:
    return answer("get_arm_run_mode", mode=desk.controller.setup.run_mode)


@command("set_arm_run_mode", "mode")
def _set_mode(desk: Desk, request: Frame) -> Frame:
    desk.controller.setup.run_mode = integer(request, "mode", 0, 1)
    return answer("set_arm_run_mode", mode=True)


@command("get_self_collision_enable")
def _self_collision(desk: Desk, request: Frame) -> Frame:
    return answer("get_self_collision_enable", enable_state=desk.controller.setup.self_collision)


@command("set_self_collision_enable", "set_state")
def _set_self_collision(desk: Desk, request: Frame) -> Frame:
    desk.controller.setup.self_collision = flag(request, "set_enable")
    return answer("set_self_collision_enable", set_state=True)
