"""Teaching: the arm moves as long as a key is held; no event tells of its end."""

import numpy as np
from bathbot_scrub.rm65.controller.protocol import Frame, integer, pose_from_wire

from bathbot_bringup.sim.arm.commands.moves import shifted
from bathbot_bringup.sim.arm.commands.planning import begin, share_of
from bathbot_bringup.sim.arm.commands.table import Desk, answer, choice, command
from bathbot_bringup.sim.arm.controller.motion_plan import Motion
from bathbot_bringup.sim.arm.controller.motion_queue import silent

_PLACES, _TURNS, _SIGNS = ("x", "y", "z"), ("rx", "ry", "rz"), ("neg", "pos")
_TURN = 500.0  # [0.001 rad] that a direction is turned at most


def _sign(request: Frame) -> int:
    return 1 if choice(request, "direction", _SIGNS) == "pos" else -1


@command("set_joint_teach", "joint_teach")
def _joint(desk: Desk, request: Frame) -> Frame:
    joint, sign, share = integer(request, "teach_joint", 1, 6) - 1, _sign(request), share_of(request)
    controller = desk.controller
    goal = np.array(controller.target)
    goal[joint] = (controller.setup.limits.upper if sign > 0 else controller.setup.limits.lower)[joint]
    begin(
        desk,
        lambda: controller.planner.joints(controller.next_start, goal, share, Motion.TEACH),
        ending=silent,
    )
    return answer("set_joint_teach", joint_teach=True)


@command("set_pos_teach", "pos_teach")
def _place(desk: Desk, request: Frame) -> Frame:
    axis, sign, share = (
        _PLACES.index(choice(request, "teach_type", _PLACES)),
        _sign(request),
        share_of(request),
    )
    controller = desk.controller
    direction = sign * controller.setup.works.T[:3, axis]
    begin(desk, lambda: controller.planner.far_line(controller.next_start, direction, share), ending=silent)
    return answer("set_pos_teach", pos_teach=True)


@command("set_ort_teach", "ort_teach")
def _turn(desk: Desk, request: Frame) -> Frame:
    axis, sign, share = _TURNS.index(choice(request, "teach_type", _TURNS)), _sign(request), share_of(request)
    offset = np.zeros(6)
    offset[3 + axis] = sign * _TURN
    goal = shifted(desk, pose_from_wire(offset), in_tool=False)
    controller = desk.controller
    begin(
        desk,
        lambda: controller.planner.line(controller.next_start, goal, share)._replace(motion=Motion.TEACH),
        ending=silent,
    )
    return answer("set_ort_teach", ort_teach=True)


@command("set_stop_teach", "stop_teach")
def _stop(desk: Desk, request: Frame) -> Frame:
    running = desk.controller.queue.current
    if running is not None and running.motion is Motion.TEACH:
        desk.controller.stop(slow=True)
    return answer("set_stop_teach", stop_teach=True)
