"""The force sensor, its calibration, and force control."""

from functools import partial

import numpy as np
from bathbot_scrub.arm.errors import ArmError, ProtocolError
from bathbot_scrub.rm65.controller.protocol import Frame, integer, integers, joints_from_wire
from numpy.typing import NDArray

from bathbot_bringup.sim.arm.commands.planning import begin, check_ready
from bathbot_bringup.sim.arm.commands.stream import smoothing, streamed_joints, streamed_pose
from bathbot_bringup.sim.arm.commands.table import Desk, answer, command
from bathbot_bringup.sim.arm.controller.force_position import ForcePosition
from bathbot_bringup.sim.arm.controller.motion_plan import Motion, Plan
from bathbot_bringup.sim.arm.controller.push import in_tool_frame, in_work_frame, wire_wrench

_CALIBRATION_SHARE = 0.2  # of the joints' speed
_CALIBRATION_DEG = (
    (0, 0, -60, 0, 60, 0),
    (0, 0, -60, 0, -30, 0),
    (0, 0, -60, 0, -30, 180),
    (0, 0, -60, 0, -120, 0),
)
_NEW = "control_mode"  # the key that tells the newer form of force control
_LIMIT = 0.1  # [m/s] of the older form; ours
_FIXED_TURN = 3  # control mode of an axis that follows the motion
_MOST_FORCE, _FASTEST = 100.0, 0.2  # [N], [m/s] that the manual allows


@command("get_force_data")
def _force_data(desk: Desk, request: Frame) -> Frame:
    controller, reading = desk.controller, desk.controller.sensor.reading
    return answer(
        "get_force_data",
        force_data=wire_wrench(reading.raw),
        zero_force_data=wire_wrench(reading.zero),
        work_zero_force_data=wire_wrench(in_work_frame(controller, reading.zero)),
        tool_zero_force_data=wire_wrench(in_tool_frame(controller, reading.zero)),
    )


@command("clear_force_data", "clear_state")
def _clear(desk: Desk, request: Frame) -> Frame:
    desk.controller.sensor.clear()
    return answer("clear_force_data", clear_state=True)


def _calibrate(desk: Desk, poses: list[NDArray[np.float64]]) -> None:
    """Go through postures [rad]; the last one ends in the reply that all is done."""
    check_ready(desk)
    controller = desk.controller
    if not controller.at_rest or controller.queue.waiting:
        raise ProtocolError("calibration begins at rest only")

    def ending(reached: bool) -> Frame:
        if reached:
            controller.sensor.calibrate()
        return answer("set_force_sensor", set_state=reached)

    def plan(pose: NDArray[np.float64]) -> Plan:
        return controller.planner.joints(controller.next_start, pose, _CALIBRATION_SHARE)

    try:
        for pose in poses[:-1]:
            begin(desk, partial(plan, pose), more=True)
        begin(desk, partial(plan, poses[-1]), ending=ending)
    except (ArmError, ProtocolError):
        controller.queue.abandon()  # the pieces that wait
        raise


@command("set_force_sensor", "set_state")
def _automatic(desk: Desk, request: Frame) -> None:
    _calibrate(desk, [np.radians(pose) for pose in _CALIBRATION_DEG])


def _enter_manual_pose(number: int) -> None:
    @command(f"manual_set_force_pose{number}", "set_state")
    def take(desk: Desk, request: Frame) -> Frame | None:
        pose = joints_from_wire(integers(request, "joint", 6))
        desk.controller.setup.limits.check(pose)
        desk.calibration[number] = pose
        if number < 4:
            return answer(f"manual_set_force_pose{number}", set_state=True)
        poses = [desk.calibration.pop(n, None) for n in (1, 2, 3, 4)]
        if any(pose is None for pose in poses):
            raise ProtocolError("four poses make a calibration, in their order")
        _calibrate(desk, poses)
        return None


for _number in (1, 2, 3, 4):
    _enter_manual_pose(_number)


@command("stop_set_force_sensor", "stop_state")
def _stop_calibration(desk: Desk, request: Frame) -> Frame:
    desk.calibration.clear()
    desk.controller.stop()
    return answer("stop_set_force_sensor", stop_state=True)


def _force_position(request: Frame) -> ForcePosition:
    """Read what is to be held, in the older or in the newer form."""
    integer(request, "sensor", 0, 1)
    in_tool = bool(integer(request, "mode", 0, 1))
    if _NEW in request:
        modes = tuple(int(value) for value in integers(request, _NEW, 6))
        if not set(modes) <= set(range(9)):
            raise ProtocolError(f"control_mode holds a mode that is none: {modes}")
        if _FIXED_TURN in modes[3:] and set(modes[3:]) != {_FIXED_TURN}:
            raise ProtocolError(f"if one turning axis follows the motion (3), all must: {modes[3:]}")
        force = integers(request, "desired_force", 6)[:3] * 0.1
        limit = np.abs(integers(request, "limit_vel", 6)[:3]) * 1e-3
        if np.abs(force).max() > _MOST_FORCE or limit.max() > _FASTEST:
            raise ProtocolError(f"force above {_MOST_FORCE} N or speed above {_FASTEST} m/s")
    else:
        axis = integer(request, "direction" if "direction" in request else "dir", 0, 5)
        size = integer(request, "N" if "N" in request else "force", -1000, 1000) * 0.1
        modes = tuple(4 if index == axis else 0 for index in range(6))
        force = np.array([size if index == axis else 0.0 for index in range(3)])
        limit = np.full(3, _LIMIT)
    return ForcePosition(in_tool, modes, force, limit)


def _check_free(desk: Desk) -> None:
    if not desk.controller.health.ready or desk.controller.health.tripped:
        raise ProtocolError("the arm has no power, or an error holds it")


@command("set_force_position", "set_state")
def _hold(desk: Desk, request: Frame) -> Frame:
    wanted = _force_position(request)
    _check_free(desk)
    desk.controller.force_position = wanted
    return answer("set_force_position", set_state=True)


@command("stop_force_position", "stop_state")
def _release(desk: Desk, request: Frame) -> Frame:
    desk.controller.force_position = None
    return answer("stop_force_position", stop_state=True)


@command("Start_Force_Position_Move", "set_state")
def _start_stream(desk: Desk, request: Frame) -> Frame:
    check_ready(desk)
    return answer("Start_Force_Position_Move", set_state=True)


@command("Stop_Force_Position_Move", "set_state")
def _stop_stream(desk: Desk, request: Frame) -> Frame:
    desk.controller.force_position = None
    return answer("Stop_Force_Position_Move", set_state=True)


@command("Force_Position_Move", "set_state")
def _stream(desk: Desk, request: Frame) -> None:
    """Take a streamed target together with a force to hold; only a refusal is answered."""
    wanted = _force_position(request)
    joints = streamed_joints(desk, request) if "joint" in request else streamed_pose(desk, request)
    _check_free(desk)
    desk.controller.force_position = wanted
    desk.controller.stream(joints, Motion.STREAM_FORCE, smoothing(request))
