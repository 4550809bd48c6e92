"""Commands of the emulated controller about forces, collisions, brakes, and the push that tells of them."""

import json

import numpy as np
import pytest
from bathbot_bringup.sim.arm.commands.table import reply
from bathbot_bringup.sim.arm.controller.push import PushSettings, datagram
from bathbot_bringup.sim.arm.emulator.surface import PlaneSurface
from bathbot_scrub.rm65.controller.protocol import joints_from_wire, pose_from_wire, quaternion_to_wire
from command_examples import EXAMPLES, JOINTS, PLACE, READY, desk_at, run
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation


@pytest.fixture
def desk():
    return desk_at()


def ask(desk, name, **fields):
    return reply(desk, {**EXAMPLES[name], **fields})


def test_a_force_is_held_against_a_wall():
    normal = -PLACE[:3, 2]
    wall = PlaneSurface(tuple(normal), float(normal @ (PLACE[:3, 3] + 0.105 * PLACE[:3, 2])))
    desk = desk_at(surface=wall)
    run(desk, 0.2)
    ask(desk, "clear_force_data")
    assert ask(desk, "set_force_position")["set_state"]  # 2 N along the tool's z
    run(desk, 4.0)
    assert np.linalg.norm(desk.controller.contact.force) == pytest.approx(2.0, abs=0.4)
    assert ask(desk, "stop_force_position")["stop_state"]
    before = desk.controller.dynamics.joints
    assert_allclose(run(desk, 0.5)[0][-1], before, atol=1e-3)


def test_a_collision_stops_the_arm_from_stage_on():
    wall = PlaneSurface(tuple(-PLACE[:3, 2]), float(-PLACE[:3, 2] @ (PLACE[:3, 3] + 0.09 * PLACE[:3, 2])))
    for stage, error in ((0, 0), (8, 0x100D)):  # 10 mm deep into the brush, then skin
        desk = desk_at(surface=wall)
        ask(desk, "set_collision_stage", collision_stage=stage)
        run(desk, 0.05)
        deeper = PLACE.copy()
        deeper[:3, 3] += 0.0015 * PLACE[:3, 2]
        desk.controller.begin(desk.controller.planner.line(READY, deeper, 0.1))
        ends = run(desk, 1.0)[2]
        assert desk.controller.health.error == error
        assert [end.reached for end in ends] == [error == 0]
        desk.controller.begin(desk.controller.planner.joints(desk.controller.target, READY, 0.5))
        assert [end.reached for end in run(desk, 1.0)[2]] == [True]  # it may leave


def test_an_emergency_stop_is_of_generation_4_only(desk):
    old = desk_at(generation=3)
    assert ask(old, "set_arm_emergency_stop") == {"command": "set_arm_emergency_stop", "receive_state": False}
    ask(desk, "movej", joint=[40000, *JOINTS[1:]])
    run(desk, 0.5)
    assert ask(desk, "set_arm_emergency_stop", emergency_stop=1)["set_state"]
    _, speeds, ends = run(desk, 0.3)
    assert [end.reached for end in ends] == [False]
    assert np.abs(speeds[25:]).max() == 0.0  # 0.125 s
    assert not ask(desk, "movej")["receive_state"]
    ask(desk, "set_arm_emergency_stop", emergency_stop=False)
    assert ask(desk, "movej")["receive_state"]


def test_a_joint_that_is_off_moves_nothing(desk):
    ask(desk, "set_joint_en_state", joint_en_state=[3, 0])
    assert ask(desk, "get_joint_en_state")["en_state"] == [1, 1, 0, 1, 1, 1]
    assert ask(desk, "get_joint_err_flag")["brake_state"] == [0, 0, 1, 0, 0, 0]
    assert not ask(desk, "movej")["receive_state"]
    ask(desk, "set_joint_en_state", joint_en_state=[3, 1])
    assert ask(desk, "movej")["receive_state"]


@given(turn=st.tuples(*[st.floats(-np.pi, np.pi)] * 3))
@settings(max_examples=50, deadline=None)
def test_the_push_writes_directions_as_the_protocol_does(turn):
    desk = desk_at()
    desk.controller.T_base_flange[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    waypoint = json.loads(datagram(desk.controller, PushSettings()).data)["waypoint"]
    expected = np.array(quaternion_to_wire(desk.controller.T_base_flange[:3, :3]))
    same = np.abs(np.array(waypoint["quat"]) - expected).max() <= 1
    assert same or np.abs(np.array(waypoint["quat"]) + expected).max() <= 1  # w = 0 has no sign
    pose = [*waypoint["position"], *waypoint["euler"]]
    assert_allclose(pose_from_wire(pose)[:3, :3], desk.controller.T_base_flange[:3, :3], atol=3e-3)


def test_the_push_holds_what_was_ordered(desk):
    run(desk, 0.05)
    plain = json.loads(datagram(desk.controller, PushSettings()).data)
    assert {"arm_current_status", "joint_status", "waypoint", "six_force_sensor"} <= set(plain)
    ask(desk, "set_realtime_push", custom={"joint_speed": 0, "arm_current_status": False})
    bare = json.loads(datagram(desk.controller, desk.push).data)
    assert "joint_speed" not in bare["joint_status"]
    assert "arm_current_status" not in bare
    raw, work, tool = (
        json.loads(datagram(desk.controller, PushSettings(force_coordinate=frame)).data)["six_force_sensor"]
        for frame in (0, 1, 2)
    )
    assert raw["zero_force"] == tool["zero_force"]  # the tool is the flange
    turned = PLACE[:3, :3] @ np.array(raw["zero_force"][:3])
    assert_allclose(work["zero_force"][:3], turned, atol=2)
    assert [block["coordinate"] for block in (raw, work, tool)] == [0, 1, 2]
    assert_allclose(joints_from_wire(bare["joint_status"]["joint_position"]), READY, atol=1e-5)
