"""Stop, pause, go on, give up."""

from bathbot_scrub.rm65.errors import ProtocolError
from bathbot_scrub.rm65.protocol import Frame

from bathbot_bringup.sim.commands.table import Desk, answer, command, flag


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
