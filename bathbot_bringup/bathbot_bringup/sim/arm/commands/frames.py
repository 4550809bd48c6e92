"""Tool and work frames: asked for, added, changed, chosen, deleted."""

from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.rm65.controller.protocol import Frame, integer, integers

from bathbot_bringup.sim.arm.commands.table import Desk, answer, command, state, word
from bathbot_bringup.sim.arm.controller.arm_setup import Frames, ToolFrame

_HEAVIEST = 10_000  # [g]; the arm carries 5 kg


def _tool_values(frames: Frames, name: str) -> Frame:
    entry = frames.get(name)
    return {
        "tool_name": name,
        "pose": list(entry.pose),
        "payload": entry.payload,
        "position": list(entry.centre),
    }


def _work_values(frames: Frames, name: str) -> Frame:
    return {"frame_name": name, "pose": list(frames.get(name).pose)}


def _whole(request: Frame, key: str, count: int) -> tuple[int, ...]:
    return tuple(int(value) for value in integers(request, key, count))


def _tool_of(request: Frame) -> ToolFrame:
    pose = _whole(request, "tool_pose" if "tool_pose" in request else "pose", 6)
    return ToolFrame(pose, integer(request, "payload", 0, _HEAVIEST), _whole(request, "position", 3))


def _work_of(request: Frame) -> ToolFrame:
    return ToolFrame(_whole(request, "frame_pose" if "frame_pose" in request else "pose", 6))


def _check_idle(desk: Desk) -> None:
    if desk.controller.busy:
        raise ProtocolError("frames are not changed while the arm moves")


@command("get_current_tool_frame")
def _tool(desk: Desk, request: Frame) -> Frame:
    tools = desk.controller.setup.tools
    return state("current_tool_frame", **_tool_values(tools, tools.current))


@command("get_current_work_frame")
def _work(desk: Desk, request: Frame) -> Frame:
    works = desk.controller.setup.works
    return state("current_work_frame", **_work_values(works, works.current))


@command("get_total_tool_frame")
def _tools(desk: Desk, request: Frame) -> Frame:
    return state("total_tool_frame", tool_names=desk.controller.setup.tools.names)


@command("get_total_work_frame")
def _works(desk: Desk, request: Frame) -> Frame:
    return state("total_work_frame", frame_names=desk.controller.setup.works.names)


@command("get_tool_frame")
def _given_tool(desk: Desk, request: Frame) -> Frame:
    return state("given_tool_frame", **_tool_values(desk.controller.setup.tools, word(request, "tool_name")))


@command("get_work_frame")
def _given_work(desk: Desk, request: Frame) -> Frame:
    return state("given_work_frame", **_work_values(desk.controller.setup.works, word(request, "frame_name")))


@command("set_manual_tool_frame", "manual_tool_frame")
def _add_tool(desk: Desk, request: Frame) -> Frame:
    desk.controller.setup.tools.add(word(request, "tool_name"), _tool_of(request))
    return answer("set_manual_tool_frame", manual_tool_frame=True)


@command("set_manual_work_frame", "manual_work_frame")
def _add_work(desk: Desk, request: Frame) -> Frame:
    desk.controller.setup.works.add(word(request, "frame_name"), _work_of(request))
    return answer("set_manual_work_frame", manual_work_frame=True)


@command("update_tool_frame", "update_state")
def _update_tool(desk: Desk, request: Frame) -> Frame:
    _check_idle(desk)
    desk.controller.setup.tools.update(word(request, "tool_name"), _tool_of(request))
    return answer("update_tool_frame", update_state=True)


@command("update_work_frame", "update_state")
def _update_work(desk: Desk, request: Frame) -> Frame:
    _check_idle(desk)
    desk.controller.setup.works.update(word(request, "frame_name"), _work_of(request))
    return answer("update_work_frame", update_state=True)


@command("set_change_tool_frame", "change_tool_frame")
def _change_tool(desk: Desk, request: Frame) -> Frame:
    _check_idle(desk)
    desk.controller.setup.tools.change(word(request, "tool_name"))
    return answer("set_change_tool_frame", change_tool_frame=True)


@command("set_change_work_frame", "change_work_frame")
def _change_work(desk: Desk, request: Frame) -> Frame:
    _check_idle(desk)
    desk.controller.setup.works.change(word(request, "frame_name"))
    return answer("set_change_work_frame", change_work_frame=True)


@command("set_delete_tool_frame", "delete_tool_frame")
def _delete_tool(desk: Desk, request: Frame) -> Frame:
    desk.controller.setup.tools.delete(word(request, "tool_name"))
    return answer("set_delete_tool_frame", delete_tool_frame=True)


@command("set_delete_work_frame", "delete_work_frame")
def _delete_work(desk: Desk, request: Frame) -> Frame:
    desk.controller.setup.works.delete(word(request, "frame_name"))
    return answer("set_delete_work_frame", delete_work_frame=True)
