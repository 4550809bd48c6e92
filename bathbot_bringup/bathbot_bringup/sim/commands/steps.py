"""Moves by a step from where the arm is: of a joint, of a place, of a direction."""

import numpy as np
from bathbot_scrub.rm65.errors import ProtocolError
from bathbot_scrub.rm65.protocol import Frame, integers, joints_from_wire, pose_from_wire

from bathbot_bringup.sim.commands.moves import shifted
from bathbot_bringup.sim.commands.planning import begin, share_of
from bathbot_bringup.sim.commands.table import Desk, answer, choice, command

_PLACES, _TURNS = ("x_step", "y_step", "z_step"), ("rx_step", "ry_step", "rz_step")


@command("set_joint_step", "receive_state")
def _joint_step(desk: Desk, request: Frame) -> Frame:
    share, (joint, step) = share_of(request), integers(request, "joint_step", 2)
    if joint not in range(1, 7):
        raise ProtocolError(f"joint must be 1 to 6, got {joint}")
    controller = desk.controller
    goal = np.array(controller.target)
    goal[int(joint) - 1] += float(joints_from_wire(step))
    begin(desk, lambda: controller.planner.joints(controller.next_start, goal, share))
    return answer("set_joint_step", receive_state=True)


def _tool_step(desk: Desk, request: Frame, axis: int) -> None:
    """Move the tool by one number of a pose, in axes of the work frame."""
    share, step = share_of(request), integers({"step": [request.get("step")]}, "step", 1)
    offset = np.zeros(6)
    offset[axis] = step[0]
    goal = shifted(desk, pose_from_wire(offset), in_tool=False)
    controller = desk.controller
    begin(desk, lambda: controller.planner.line(controller.next_start, goal, share))


@command("set_pos_step", "receive_state")
def _place_step(desk: Desk, request: Frame) -> Frame:
    _tool_step(desk, request, _PLACES.index(choice(request, "step_type", _PLACES)))
    return answer("set_pos_step", receive_state=True)


@command("set_ort_step", "receive_state")
def _turn_step(desk: Desk, request: Frame) -> Frame:
    _tool_step(desk, request, 3 + _TURNS.index(choice(request, "step_type", _TURNS)))
    return answer("set_ort_step", receive_state=True)
