"""Settings that are kept and told again, power, and what holds or ends a motion.

In this order: mounting, initial posture, collision stage, modes; power of arm and joints; stop, pause, go on,
delete, emergency stop.
"""

from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.rm65.controller.protocol import Frame, integer, integers, joints_from_wire

from bathbot_bringup.sim.arm.commands.table import Desk, answer, command, flag, state


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


@command("get_arm_power_state")
def _power(desk: Desk, request: Frame) -> Frame:
    return state("arm_power_state", power_state=int(desk.controller.health.power))


@command("set_arm_power", "arm_power")
def _set_power(desk: Desk, request: Frame) -> Frame:
    desk.controller.set_power(bool(integer(request, "arm_power", 0, 1)))
    return answer("set_arm_power", arm_power=True)


@command("set_joint_en_state", "joint_en_state")
def _enable(desk: Desk, request: Frame) -> Frame:
    joint, on = integers(request, "joint_en_state", 2)
    if joint not in range(1, 7) or on not in (0, 1):
        raise ProtocolError(f"joint_en_state must be [1 to 6, 0 or 1], got {[joint, on]}")
    desk.controller.enable(int(joint) - 1, bool(on))
    return answer("set_joint_en_state", joint_en_state=True)


@command("set_arm_stop", "arm_stop")
def _stop(desk: Desk, request: Frame) -> Frame:
    desk.controller.stop()
    return answer("set_arm_stop", arm_stop=True)


@command("set_arm_slow_stop", "arm_slow_stop")
def _slow_stop(desk: Desk, request: Frame) -> Frame:
    desk.controller.stop(slow=True)
    return answer("set_arm_slow_stop", arm_slow_stop=True)


@command("set_arm_pause", "arm_pause")
def _pause(desk: Desk, request: Frame) -> Frame:
    desk.controller.queue.pause()
    return answer("set_arm_pause", arm_pause=True)


@command("set_arm_continue", "arm_continue")
def _continue(desk: Desk, request: Frame) -> Frame:
    desk.controller.queue.go_on()
    return answer("set_arm_continue", arm_continue=True)


def _delete(desk: Desk) -> None:
    """Give up the motion in which the arm pauses; its pieces are not told apart."""
    if not desk.controller.queue.paused:
        raise ProtocolError("a trajectory is deleted after a pause only; call set_arm_pause first")
    desk.controller.queue.delete()


@command("set_delete_current_trajectory", "delete_current_trajectory")
def _delete_current(desk: Desk, request: Frame) -> Frame:
    _delete(desk)
    return answer("set_delete_current_trajectory", delete_current_trajectory=True)


@command("set_arm_delete_trajectory", "arm_delete_trajectory")
def _delete_all(desk: Desk, request: Frame) -> Frame:
    _delete(desk)
    return answer("set_arm_delete_trajectory", arm_delete_trajectory=True)


@command("set_arm_emergency_stop", "set_state", since=4)
def _emergency(desk: Desk, request: Frame) -> Frame:
    desk.controller.stop_at_once(flag(request, "emergency_stop"))
    return answer("set_arm_emergency_stop", set_state=True)
