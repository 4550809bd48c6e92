"""Targets that clients stream: joints, poses, velocities. Nothing is answered, as on generations 3 and 4."""

import numpy as np
from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.arm.errors import ArmError, ProtocolError
from bathbot_scrub.rm65.arm.inverse_kinematics import solve_head
from bathbot_scrub.rm65.controller.protocol import (
    Frame,
    integer,
    integers,
    joints_from_wire,
    pose_from_wire,
    quaternion_from_wire,
)
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bathbot_bringup.sim.arm.commands.table import Desk, answer, command, flag
from bathbot_bringup.sim.arm.controller.arm_health import OVER_SPEED, UNREACHABLE
from bathbot_bringup.sim.arm.controller.joint_stream import lag
from bathbot_bringup.sim.arm.controller.motion_plan import Motion

Array = NDArray[np.float64]
_FASTEST, _FASTEST_TURN = 0.25, 0.6  # [m/s], [rad/s] of movev_canfd
_SLACK = 1.001  # for rounding


def smoothing(request: Frame) -> float:
    """Time constant [s] with which a streamed target is smoothed."""
    follow = flag(request, "follow") if "follow" in request else True
    mode = integer(request, "trajectory_mode", 0, 2) if "trajectory_mode" in request else 0
    return lag(follow, mode, integer(request, "radio", 0, 1000) if "radio" in request else 0)


def flange_goal(desk: Desk, request: Frame) -> Array:
    """Pose of the flange (4, 4) of a request that holds `pose` or `pose_quat`."""
    if "pose_quat" in request:
        values, T = integers(request, "pose_quat", 7), np.eye(4)
        T[:3, 3], T[:3, :3] = values[:3] * 1e-6, quaternion_from_wire(values[3:])
    else:
        T = pose_from_wire(integers(request, "pose", 6))
    return desk.controller.setup.flange_pose(T)


def joints_for(desk: Desk, T_base_flange: Array) -> Array:
    """Joints [rad], shape (6,), nearest to the target, that hold the flange at a pose.

    Raises:
        ArmError: Out of reach; the error is kept.
    """
    controller = desk.controller
    kinematics, limits = controller.arm.kinematics, controller.setup.limits
    try:
        solutions = solve_head(kinematics, T_base_flange @ kinematics.tool.T_flange_head, limits)
        return nearest(solutions, controller.target, limits)
    except ArmError:
        controller.health.error = UNREACHABLE
        raise


def streamed_joints(desk: Desk, request: Frame) -> Array:
    """Joints of a frame [rad], shape (6,), and a note of it in the trace."""
    joints = joints_from_wire(integers(request, "joint", 6))
    desk.trace.frame(desk.clock(), joints)
    return joints


def streamed_pose(desk: Desk, request: Frame) -> Array:
    """Joints [rad], shape (6,), of a frame that holds a pose, and a note of it in the trace."""
    joints = joints_for(desk, flange_goal(desk, request))
    desk.trace.frame(desk.clock(), joints)
    return joints


@command("movej_canfd", refusal="")
def _movej_canfd(desk: Desk, request: Frame) -> None:
    desk.controller.stream(streamed_joints(desk, request), Motion.STREAM, smoothing(request))


@command("movep_canfd", refusal="")
def _movep_canfd(desk: Desk, request: Frame) -> None:
    desk.controller.stream(streamed_pose(desk, request), Motion.STREAM_POSE, smoothing(request))


@command("movej_follow", refusal="")
def _movej_follow(desk: Desk, request: Frame) -> None:
    desk.controller.stream(streamed_joints(desk, request), Motion.MOVE_J, led=True)


@command("movep_follow", refusal="")
def _movep_follow(desk: Desk, request: Frame) -> None:
    desk.controller.stream(streamed_pose(desk, request), Motion.MOVE_J, led=True)


@command("set_movev_canfd_init", "movev_canfd_init_state")
def _announce_velocity(desk: Desk, request: Frame) -> Frame:
    """Remember axes (tool or work) and period of the velocity frames that follow."""
    if "avoid_singularity_flag" in request:
        flag(request, "avoid_singularity_flag")  # a singular posture is never passed here
    period = integer(request, "dt", 1, 100) / 1000.0
    desk.velocity_frame = (bool(integer(request, "frame_type", 0, 1)), period)
    return answer("set_movev_canfd_init", movev_canfd_init_state=True)


@command("movev_canfd", refusal="")
def _movev_canfd(desk: Desk, request: Frame) -> None:
    """Move the target by a velocity for one period."""
    if desk.velocity_frame is None:
        raise ProtocolError("movev_canfd before set_movev_canfd_init")
    in_tool, period = desk.velocity_frame
    velocity = integers(request, "cartesian_velocity", 6) * np.repeat([1e-6, 1e-3], 3)
    controller = desk.controller
    if (np.abs(velocity) > _SLACK * np.repeat([_FASTEST, _FASTEST_TURN], 3)).any():
        controller.health.error = OVER_SPEED
        raise ProtocolError("velocity above 0.25 m/s or 0.6 rad/s")
    T = controller.setup.tool_pose(controller.arm.kinematics.flange(controller.target))
    axes = T[:3, :3].copy() if in_tool else np.eye(3)
    T[:3, 3] += period * axes @ velocity[:3]
    T[:3, :3] = Rotation.from_rotvec(period * axes @ velocity[3:]).as_matrix() @ T[:3, :3]
    joints = joints_for(desk, controller.setup.flange_pose(T))
    desk.trace.frame(desk.clock(), joints)
    controller.stream(joints, Motion.STREAM_VELOCITY, smoothing(request))
