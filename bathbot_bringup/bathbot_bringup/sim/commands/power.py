"""Power of the arm and of its joints."""

from bathbot_scrub.rm65.errors import ProtocolError
from bathbot_scrub.rm65.protocol import Frame, integer, integers

from bathbot_bringup.sim.commands.table import Desk, answer, command, state


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
