"""Planned moves: movej, movej_p, movel, movel_offset, movec, moves, and steps as from a teach panel.

With trajectory_connect 1 a piece waits for the next one; all of them end in one event. The blending radius
`r` is accepted, but corners are not blended.
"""

import numpy as np
from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.rm65.controller.protocol import Frame, integer, integers, joints_from_wire, pose_from_wire
from numpy.typing import NDArray

from bathbot_bringup.sim.arm.commands.planning import begin, check_ready, share_of
from bathbot_bringup.sim.arm.commands.table import Desk, answer, choice, command
from bathbot_bringup.sim.arm.controller.motion_plan import Motion

Array = NDArray[np.float64]
_MOST_LOOPS = 20
_MOST_PIECES = 100
_PLACES, _TURNS = ("x_step", "y_step", "z_step"), ("rx_step", "ry_step", "rz_step")


def _more(desk: Desk, request: Frame) -> bool:
    """Whether another piece follows, and whether there is room for it."""
    if "r" in request:
        integer(request, "r", 0, 100)
    if len(desk.controller.queue.waiting) >= _MOST_PIECES:
        raise ProtocolError(f"more than {_MOST_PIECES} connected moves; end the trajectory")
    return "trajectory_connect" in request and bool(integer(request, "trajectory_connect", 0, 1))


def _flange(desk: Desk, pose: Array) -> Array:
    """Pose of the flange in the base of a pose on the wire, shape (6,)."""
    return desk.controller.setup.flange_pose(pose_from_wire(pose))


def shifted(desk: Desk, offset: Array, in_tool: bool) -> Array:
    """Pose of the flange after the tool has moved by an offset (4, 4), in its own or in work axes."""
    controller = desk.controller
    T = controller.setup.tool_pose(controller.arm.kinematics.flange(controller.next_start))
    if in_tool:
        return controller.setup.flange_pose(T @ offset)
    T[:3, 3] += offset[:3, 3]
    T[:3, :3] = offset[:3, :3] @ T[:3, :3]
    return controller.setup.flange_pose(T)


@command("movej", "receive_state")
def _movej(desk: Desk, request: Frame) -> Frame:
    share, goal = share_of(request), joints_from_wire(integers(request, "joint", 6))
    controller = desk.controller
    begin(desk, lambda: controller.planner.joints(controller.next_start, goal, share), _more(desk, request))
    return answer("movej", receive_state=True)


@command("movej_p", "receive_state")
def _movej_p(desk: Desk, request: Frame) -> Frame:
    share, goal = share_of(request), _flange(desk, integers(request, "pose", 6))
    controller = desk.controller
    begin(desk, lambda: controller.planner.pose(controller.next_start, goal, share), _more(desk, request))
    return answer("movej_p", receive_state=True)


@command("movel", "receive_state")
def _movel(desk: Desk, request: Frame) -> Frame:
    share, goal = share_of(request), _flange(desk, integers(request, "pose", 6))
    controller = desk.controller
    begin(desk, lambda: controller.planner.line(controller.next_start, goal, share), _more(desk, request))
    return answer("movel", receive_state=True)


@command("movel_offset", "receive_state", since=4)
def _movel_offset(desk: Desk, request: Frame) -> Frame:
    share, in_tool = share_of(request), bool(integer(request, "frame_type", 0, 1))
    goal = shifted(desk, pose_from_wire(integers(request, "offset", 6)), in_tool)
    controller = desk.controller
    begin(desk, lambda: controller.planner.line(controller.next_start, goal, share), _more(desk, request))
    return answer("movel_offset", receive_state=True)


@command("movec", "receive_state")
def _movec(desk: Desk, request: Frame) -> Frame:
    share, loops = share_of(request), integer(request, "loop", 0, _MOST_LOOPS) if "loop" in request else 0
    poses = request.get("pose")
    if not isinstance(poses, dict):
        raise ProtocolError(f"pose must hold pose_via and pose_to, got {str(poses)[:60]}")
    via, to = (_flange(desk, integers(poses, key, 6)) for key in ("pose_via", "pose_to"))
    controller = desk.controller
    more = _more(desk, request)
    begin(desk, lambda: controller.planner.arc(controller.next_start, via, to, share, loops), more)
    return answer("movec", receive_state=True)


@command("moves", "receive_state")
def _moves(desk: Desk, request: Frame) -> Frame:
    """Take one point of a smooth curve; the points before it are those of the connected pieces."""
    share, goal = share_of(request), _flange(desk, integers(request, "pose", 6))
    controller, more = desk.controller, _more(desk, request)
    check_ready(desk)
    waiting = controller.queue.waiting
    joined = bool(waiting) and waiting[-1].motion is Motion.MOVE_S
    corners = waiting[-1].corners if joined else ()
    start = waiting[-1].path.joints[0] if joined else controller.next_start
    points = np.stack([*corners, goal])
    if len(points) > _MOST_PIECES:
        raise ProtocolError(f"more than {_MOST_PIECES} points of a curve; end it")
    begin(desk, lambda: controller.planner.curve(start, points, share), more, replaces=joined)
    return answer("moves", receive_state=True)


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
