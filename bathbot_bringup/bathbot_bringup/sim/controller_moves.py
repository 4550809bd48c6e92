"""The commands of the table that move or stop the arm."""

import time

from bathbot_scrub.rm65.errors import ProtocolError
from bathbot_scrub.rm65.protocol import Frame, integer, integers, joints_from_wire, pose_from_wire

from bathbot_bringup.sim.controller_replies import Desk, command


def _accept(desk: Desk, request: Frame) -> float:
    """Check what all planned moves share; give the share of full speed, 0..1."""
    if not desk.controller.power:
        raise ProtocolError("the arm has no power")
    if desk.controller.busy:
        raise ProtocolError("a planned motion is on its way")  # queue or replace: not published
    if integer(request, "trajectory_connect", 0, 1) if "trajectory_connect" in request else 0:
        raise ProtocolError("chained moves are not emulated yet")
    return integer(request, "v", 1, 100) / 100.0


@command("movej")
def _movej(desk: Desk, request: Frame) -> Frame:
    share = _accept(desk, request)
    desk.controller.move_joints(joints_from_wire(integers(request, "joint", 6)), share)
    return {"command": "movej", "receive_state": True}


@command("movej_p")
def _movej_p(desk: Desk, request: Frame) -> Frame:
    share = _accept(desk, request)
    desk.controller.move_to_pose(pose_from_wire(integers(request, "pose", 6)), share)
    return {"command": "movej_p", "receive_state": True}


@command("movel")
def _movel(desk: Desk, request: Frame) -> Frame:
    share = _accept(desk, request)
    desk.controller.move_line(pose_from_wire(integers(request, "pose", 6)), share)
    return {"command": "movel", "receive_state": True}


@command("movej_canfd")
def _movej_canfd(desk: Desk, request: Frame) -> None:
    joints = joints_from_wire(integers(request, "joint", 6))
    desk.trace.frame(time.monotonic(), joints)
    desk.controller.stream(joints)


@command("set_arm_stop")
def _stop(desk: Desk, request: Frame) -> Frame:
    desk.controller.stop()
    return {"command": "set_arm_stop", "arm_stop": True}


@command("set_arm_slow_stop")
def _slow_stop(desk: Desk, request: Frame) -> Frame:
    desk.controller.stop(slow=True)
    return {"command": "set_arm_slow_stop", "arm_slow_stop": True}


@command("set_arm_pause")
def _pause(desk: Desk, request: Frame) -> Frame:
    desk.controller.pause()
    return {"command": "set_arm_pause", "arm_pause": True}


@command("set_arm_continue")
def _continue(desk: Desk, request: Frame) -> Frame:
    desk.controller.go_on()
    return {"command": "set_arm_continue", "arm_continue": True}
