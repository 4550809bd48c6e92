"""The command table of the emulated controller: what is set is told again, what cannot be is refused."""

import json
from contextlib import contextmanager

import numpy as np
import pytest
from bathbot_bringup.sim.arm.commands.table import COMMANDS, reply
from bathbot_bringup.sim.arm.controller.arm_health import ARC_IMPOSSIBLE, TARGET_OVER_LIMIT, UNREACHABLE
from bathbot_bringup.sim.arm.controller.motion_plan import Motion
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.controller.protocol import pose_from_wire
from command_examples import EXAMPLES, JOINTS, PLACE, READY, desk_at, place, run
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

NEEDS_MORE = {"set_delete_current_trajectory", "set_arm_delete_trajectory", "manual_set_force_pose4",
              "update_tool_frame", "set_delete_tool_frame", "update_work_frame", "set_delete_work_frame",
              "movev_canfd"}  # fmt: skip


@pytest.fixture
def desk():
    return desk_at()


def ask(desk, name, **fields):
    return reply(desk, {**EXAMPLES[name], **fields})


def test_there_is_an_example_of_every_command():
    assert set(EXAMPLES) == set(COMMANDS)


@pytest.mark.parametrize("name", sorted(set(EXAMPLES) - NEEDS_MORE))
def test_a_good_request_is_granted(desk, name):
    answer = reply(desk, EXAMPLES[name])
    json.dumps(answer, allow_nan=False)
    refusal = COMMANDS[name].refusal
    assert answer is None or answer.get(refusal, True) is not False


@pytest.mark.parametrize("name", sorted(NEEDS_MORE))
def test_what_needs_something_before_it_is_refused_without(desk, name):
    answer = reply(desk, EXAMPLES[name])
    assert answer is None or answer[COMMANDS[name].refusal] is False


@pytest.mark.parametrize(
    ("setter", "getter", "key", "value"),
    [
        ("set_joint_max_speed", "get_joint_max_speed", "joint_speed", 20000),
        ("set_joint_max_acc", "get_joint_max_acc", "joint_acc", 50000),
        ("set_joint_min_pos", "get_joint_min_pos", "min_pos", -170000),
        ("set_joint_max_pos", "get_joint_max_pos", "max_pos", 170000),
    ],
)
def test_limits_of_joints_are_kept_one_by_one(desk, setter, getter, key, value):
    before = ask(desk, getter)[key]
    ask(desk, setter)
    after = ask(desk, getter)[key]
    assert after == [value, *before[1:]]
    name = setter.removeprefix("set_")
    assert ask(desk, setter, **{name: [1, 10**9]})[name] is False
    assert ask(desk, getter)[key] == after
    assert ask(desk, getter.replace("joint_", "joint_drive_"))[key][1:] == before[1:]


@pytest.mark.parametrize(
    ("setter", "getter", "key", "value"),
    [
        ("set_arm_max_line_speed", "get_arm_max_line_speed", "arm_line_speed", 200),
        ("set_arm_max_angular_acc", "get_arm_max_angular_acc", "arm_angular_acc", 3000),
        ("set_collision_stage", "get_collision_stage", "collision_stage", 3),
        ("set_arm_run_mode", "get_arm_run_mode", "mode", 0),
        ("set_install_pose", "get_install_pose", "pose", [0, 90, 0]),
        ("set_init_pose", "get_init_pose", "init_pose", JOINTS),
        ("set_self_collision_enable", "get_self_collision_enable", "enable_state", True),
        ("set_realtime_push", "get_realtime_push", "cycle", 2),
        ("set_joint_en_state", "get_joint_en_state", "en_state", [1] * 6),
    ],
)
def test_what_is_set_is_told_again(desk, setter, getter, key, value):
    ask(desk, setter)
    assert ask(desk, getter)[key] == value
    ask(desk, "set_arm_init")
    assert ask(desk, "get_arm_max_line_speed")["arm_line_speed"] == 250


@pytest.mark.parametrize("sort", ["tool", "work"])
def test_frames_are_added_used_changed_and_deleted(desk, sort):
    name = {"tool": "brush", "work": "bath"}[sort]
    key = {"tool": "tool_name", "work": "frame_name"}[sort]
    assert ask(desk, f"set_manual_{sort}_frame")[f"manual_{sort}_frame"]
    assert not ask(desk, f"set_manual_{sort}_frame")[f"manual_{sort}_frame"]  # the name is taken
    assert name in ask(desk, f"get_total_{sort}_frame")[f"{key}s"]
    before = pose_from_wire(ask(desk, "get_current_arm_state")["arm_state"]["pose"])
    assert ask(desk, f"set_change_{sort}_frame", **{key: name})[f"change_{sort}_frame"]
    after = pose_from_wire(ask(desk, "get_current_arm_state")["arm_state"]["pose"])
    assert np.linalg.norm((after - before)[:3, 3]) == pytest.approx(0.1, abs=1e-5)
    assert ask(desk, f"get_current_{sort}_frame")[key] == name
    assert not ask(desk, f"set_delete_{sort}_frame")[f"delete_{sort}_frame"]  # in use
    assert ask(desk, f"set_change_{sort}_frame")[f"change_{sort}_frame"]
    assert ask(desk, f"update_{sort}_frame")["update_state"]
    assert ask(desk, f"set_delete_{sort}_frame")[f"delete_{sort}_frame"]
    assert not ask(desk, f"get_{sort}_frame", **{key: name}).get("get_state", True)


def test_a_move_is_meant_for_the_tool_in_the_work_frame(desk):
    ask(desk, "set_manual_tool_frame")
    ask(desk, "set_manual_work_frame")
    ask(desk, "set_change_tool_frame", tool_name="brush")
    ask(desk, "set_change_work_frame", frame_name="bath")
    goal = ask(desk, "get_current_arm_state")["arm_state"]["pose"]
    goal[1] += 30000
    assert ask(desk, "movel", pose=goal)["receive_state"]
    assert run(desk, 3.0)[2][0].reached
    reached = ask(desk, "get_current_arm_state")["arm_state"]["pose"]
    assert_allclose(pose_from_wire(reached), pose_from_wire(goal), atol=2e-3)
    assert_allclose(desk.controller.T_base_flange[:3, 3], PLACE[:3, 3] + [0.0, 0.03, 0.0], atol=2e-4)


def test_an_arc_passes_its_point_and_keeps_its_radius(desk):
    ask(desk, "movec")
    joints, _, ends = run(desk, 4.0)
    places = RM65("6F").flange(joints)[:, :3, 3] - PLACE[:3, 3]
    assert [end.reached for end in ends] == [True]
    assert_allclose(np.hypot(places[:, 1] - 0.02, places[:, 2]), 0.02, atol=2e-4)
    assert places[:, 2].max() == pytest.approx(0.02, abs=3e-4)
    assert_allclose(places[-1], [0.0, 0.04, 0.0], atol=1e-4)
    straight = {"pose_via": place(y=0.06), "pose_to": place(y=0.08)}
    assert not ask(desk, "movec", pose=straight)["receive_state"]
    assert desk.controller.health.error == ARC_IMPOSSIBLE


def test_a_curve_passes_its_points(desk):
    points = [(0.01, 0.02), (0.03, 0.03), (0.04, 0.0)]
    for index, (y, z) in enumerate(points):
        assert ask(desk, "moves", pose=place(y=y, z=z), trajectory_connect=int(index < 2))["receive_state"]
        assert ask(desk, "get_arm_current_trajectory")["type"] == ("none" if index < 2 else "moves")
    joints, _, ends = run(desk, 4.0)
    assert [end.reached for end in ends] == [True]
    places = RM65("6F").flange(joints)[:, :3, 3] - PLACE[:3, 3]
    for y, z in points:
        assert np.linalg.norm(places - [0.0, y, z], axis=1).min() < 1e-3


def test_connected_moves_end_in_one_event(desk):
    assert ask(desk, "movej", trajectory_connect=1)["receive_state"]
    assert run(desk, 0.2)[2] == []
    assert ask(desk, "movel", pose=place(y=0.05), trajectory_connect=1)["receive_state"]
    assert ask(desk, "movej", joint=JOINTS)["receive_state"]
    joints, _, ends = run(desk, 6.0)
    assert [end.reached for end in ends] == [True]
    assert ends[0].frame["trajectory_connect"] == 0
    assert_allclose(joints[-1], READY, atol=2e-4)
    assert np.abs(joints[:, 0] - np.radians(5.0)).min() < 1e-3


@pytest.mark.parametrize(
    ("name", "fields", "code"),
    [
        ("movej", {"joint": [179000, 0, 0, 0, 0, 0]}, TARGET_OVER_LIMIT),
        ("movej_p", {"pose": place(x=1.0)}, UNREACHABLE),
        ("movel", {"pose": place(x=1.0)}, UNREACHABLE),
        ("set_joint_step", {"joint_step": [1, 200000]}, TARGET_OVER_LIMIT),
    ],
)
def test_why_a_move_was_refused_is_kept_until_the_next_one(desk, name, fields, code):
    assert not ask(desk, name, **fields)["receive_state"]
    assert ask(desk, "get_current_arm_state")["arm_state"]["err"] == [code]
    assert ask(desk, "movej")["receive_state"]
    assert ask(desk, "get_current_arm_state")["arm_state"]["err"] == [0]


@pytest.mark.parametrize("name", ["set_joint_teach", "set_pos_teach", "set_ort_teach"])
def test_teaching_moves_until_it_is_stopped_and_tells_nobody(desk, name):
    ask(desk, name)
    joints, _, ends = run(desk, 1.0)
    assert desk.controller.motion is Motion.TEACH
    assert np.abs(joints[-1] - READY).max() > 0.005
    ask(desk, "set_stop_teach")
    assert [end.frame for end in ends + run(desk, 1.0)[2]] == [None]
    assert desk.controller.motion is Motion.IDLE
    assert ask(desk, "movej", joint=JOINTS)["receive_state"]


@pytest.mark.parametrize("name", ["set_delete_current_trajectory", "set_arm_delete_trajectory"])
def test_a_trajectory_is_given_up_in_a_pause_with_one_false_event(desk, name):
    ask(desk, "movej", joint=[40000, *JOINTS[1:]])
    run(desk, 0.3)
    ask(desk, "set_arm_pause")
    run(desk, 0.5)
    assert reply(desk, EXAMPLES[name])[COMMANDS[name].refusal]
    assert [end.reached for end in run(desk, 0.2)[2]] == [False]
    assert not desk.controller.busy


def test_calibration_goes_through_its_postures_and_ends_in_its_reply(desk):
    assert ask(desk, "set_force_sensor") is None
    joints, _, ends = run(desk, 16.0)
    assert [end.frame for end in ends] == [{"command": "set_force_sensor", "set_state": True}]
    for posture in ([0, 0, -60, 0, 60, 0], [0, 0, -60, 0, -30, 180], [0, 0, -60, 0, -120, 0]):
        assert np.abs(joints - np.radians(posture)).max(1).min() < 1e-3
    assert np.linalg.norm(desk.controller.sensor.reading.zero[:3]) < 0.3  # drift and weight are known now
    ask(desk, "set_force_sensor")
    run(desk, 0.5)
    assert ask(desk, "stop_set_force_sensor")["stop_state"]
    assert [end.frame["set_state"] for end in run(desk, 1.0)[2]] == [False]


def test_velocities_are_integrated_in_tool_axes(desk):
    ask(desk, "set_movev_canfd_init")
    for _ in range(50):
        ask(desk, "movev_canfd")
        run(desk, 0.01)
    run(desk, 0.3)
    moved = PLACE[:3, :3].T @ (desk.controller.T_base_flange[:3, 3] - PLACE[:3, 3])
    assert_allclose(moved, [0.0, 0.01, 0.0], atol=2e-4)


def test_the_arm_goes_on_while_a_move_is_planned(desk):
    went_on = []

    @contextmanager
    def aside():
        went_on.append(desk.controller.step())
        yield

    desk.aside = aside
    assert ask(desk, "movel")["receive_state"]
    assert went_on == [[]]


def test_connected_moves_are_off_when_the_arm_has_moved_since(desk):
    assert ask(desk, "movej", trajectory_connect=1)["receive_state"]
    for step in range(1, 21):
        ask(desk, "movej_canfd", joint=[step * 500, *JOINTS[1:]])
        run(desk, 0.01)
    run(desk, 0.3)
    before = desk.controller.dynamics.joints
    assert not ask(desk, "movej")["receive_state"]
    assert_allclose(run(desk, 0.2)[0][-1], before, atol=1e-6)
    assert ask(desk, "movej")["receive_state"]


def test_a_fault_that_comes_while_a_move_is_planned_wins(desk):
    @contextmanager
    def aside():
        yield
        desk.controller.cut_power()

    desk.aside = aside
    assert not ask(desk, "movel")["receive_state"]
    assert not desk.controller.busy


@given(
    steps=st.lists(
        st.tuples(st.sampled_from(sorted(EXAMPLES)), st.integers(0, 1), st.sampled_from([0.0, 0.02, 0.3])),
        max_size=12,
    )
)
# few, for each moves the arm for seconds of its own time
@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_in_any_order_every_accepted_move_ends_in_exactly_one_event(steps):
    desk, accepted, told = desk_at(), 0, []
    for name, connect, pause in [*steps, ("movej", 0, 0.1), ("set_arm_stop", 0, 2.0)]:
        fields = {"trajectory_connect": connect} if "trajectory_connect" in EXAMPLES[name] else {}
        answer = ask(desk, name, **fields)
        granted = answer is not None and answer.get("receive_state") is True
        accepted += granted and not fields.get("trajectory_connect")
        joints, _, ends = run(desk, pause)
        told += [end.frame for end in ends if end.frame and "trajectory_state" in end.frame]
        assert np.isfinite(joints).all()
        assert desk.controller.setup.limits.contain(desk.controller.dynamics.joints, -np.radians(1.0))
    assert len(told) == accepted
    assert not desk.controller.busy
    assert desk.controller.at_rest
