"""The emulated controller without a wire, stepped by hand."""

import json

import numpy as np
import pytest
from bathbot_bringup.sim.arm import commands  # noqa: F401 - fills the table
from bathbot_bringup.sim.arm.commands.table import COMMANDS, Desk, reply
from bathbot_bringup.sim.arm.controller.arm_health import OVER_SPEED, TARGET_OVER_LIMIT
from bathbot_bringup.sim.arm.controller.arm_setup import Arm
from bathbot_bringup.sim.arm.controller.controller import STEP, Controller
from bathbot_bringup.sim.arm.controller.joint_dynamics import JointDynamics
from bathbot_bringup.sim.arm.controller.motion_plan import Motion
from bathbot_bringup.sim.arm.controller.push import PushSettings, datagram
from bathbot_bringup.sim.arm.emulator.surface import NoSurface
from bathbot_bringup.sim.brush import Brush
from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.rm65.arm.limits import HOME_DEG, RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.controller.protocol import joints_from_wire, pose_from_wire, pose_to_wire
from bathbot_scrub.rm65.controller.state_push import parse_sample
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

HOME = np.radians(HOME_DEG)
CONNECT = [
    "get_arm_software_info",
    "get_arm_current_trajectory",
    "get_realtime_push",
    "get_current_work_frame",
    "get_current_tool_frame",
    "get_install_pose",
    "get_joint_min_pos",
    "get_joint_max_pos",
    "get_joint_max_acc",
    "get_joint_max_speed",
    "get_DH_data",
]


@pytest.fixture
def desk():
    arm = Arm(RM65("6F"), RM65_LIMITS, Brush())
    return Desk(Controller(arm, HOME, NoSurface(), lambda: 0.0, np.random.default_rng(0)))


def run(controller, seconds):
    """Step; give positions after every step, and the ends of motions."""
    path, ends = [], []
    for _ in range(round(seconds / STEP)):
        ends += controller.step()
        path.append(controller.dynamics.joints)
    return np.array(path), ends


@given(goal=st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6))
@settings(max_examples=30, deadline=None)
def test_joints_reach_a_target_within_speed_and_acceleration(goal):
    dynamics = JointDynamics(np.zeros(6), RM65_LIMITS)
    speeds = [np.zeros(6)]
    for _ in range(600):
        dynamics.step(goal, STEP)
        speeds.append(np.array(dynamics.speeds))
    assert_allclose(dynamics.joints, goal, atol=1e-4)
    assert dynamics.at_rest(goal)
    assert (np.abs(speeds) <= RM65_LIMITS.speed + 1e-9).all()
    assert np.abs(np.diff(speeds, axis=0)).max() <= np.radians(600.0) * STEP + 1e-9


@pytest.mark.parametrize("name", CONNECT)
def test_the_queries_of_a_connecting_client_are_answered(desk, name):
    answer = reply(desk, {"command": name})
    assert answer.get("command", answer.get("state")) in (name, name.removeprefix("get_"))
    json.dumps(answer, allow_nan=False)


def test_wire_values_of_the_connect_queries(desk):
    assert reply(desk, {"command": "get_arm_software_info"})["Product_version"] == "RM65-6FI"
    assert reply(desk, {"command": "get_joint_max_speed"})["joint_speed"] == [
        30000,
        30000,
        37500,
        37500,
        37500,
        37500,
    ]
    assert reply(desk, {"command": "get_joint_max_pos"})["max_pos"] == [
        178000,
        130000,
        135000,
        178000,
        128000,
        360000,
    ]
    assert reply(desk, {"command": "get_DH_data"})["joint_6"] == [90000, 0, 172500, 0]


def test_every_command_takes_an_empty_request_without_raising(desk):
    for name in COMMANDS:
        answer = reply(desk, {"command": name})
        assert answer is None or isinstance(answer, dict)


@given(
    name=st.sampled_from(sorted(COMMANDS)),
    extra=st.dictionaries(
        st.sampled_from(
            ["joint", "pose", "v", "trajectory_connect", "cycle", "port", "ip", "enable", "arm_power"]
        ),
        st.none()
        | st.booleans()
        | st.floats()
        | st.text(max_size=5)
        | st.lists(st.integers() | st.floats(), max_size=7),
    ),
)
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_hostile_values_never_raise_nor_move_beyond_the_limits(name, extra):
    arm = Arm(RM65("6F"), RM65_LIMITS, Brush())
    desk = Desk(Controller(arm, HOME, NoSurface(), lambda: 0.0, np.random.default_rng(0)))
    answer = reply(desk, {**extra, "command": name})
    json.dumps(answer, allow_nan=False)
    run(desk.controller, 0.03)
    assert RM65_LIMITS.contain(desk.controller.dynamics.joints, -1e-6)


def test_a_request_without_command_is_an_error_and_an_unknown_one_is_refused(desk):
    with pytest.raises(ProtocolError):
        reply(desk, {"joint": [0]})
    assert reply(desk, {"command": "make_tea"}) == {"command": "make_tea", "receive_state": False}


def test_movej_arrives_with_one_event(desk):
    goal = [0, -10000, -90000, 0, -40000, 0]
    assert reply(desk, {"command": "movej", "v": 50, "joint": goal, "trajectory_connect": 0})["receive_state"]
    path, ends = run(desk.controller, 4.0)
    assert_allclose(path[-1], joints_from_wire(goal), atol=2e-4)
    assert [end.reached for end in ends] == [True]
    assert desk.controller.motion is Motion.IDLE


def test_movel_is_straight(desk):
    controller = desk.controller
    controller.dynamics = JointDynamics(np.radians([0, -10, -90, 0, -40, 0]), RM65_LIMITS)
    controller.target = controller.dynamics.joints
    controller.step()
    begin = controller.T_base_flange.copy()
    end = begin.copy()
    end[:3, 3] += (0.02, 0.08, 0.0)
    assert reply(desk, {"command": "movel", "v": 40, "pose": pose_to_wire(end)})["receive_state"]
    path, ends = run(controller, 3.0)
    moved = RM65("6F").flange(path)[:, :3, 3] - begin[:3, 3]
    direction = (end - begin)[:3, 3] / np.linalg.norm((end - begin)[:3, 3])
    assert [e.reached for e in ends] == [True]
    assert np.linalg.norm(np.cross(moved, direction), axis=1).max() < 1e-4
    assert_allclose(controller.T_base_flange[:3, 3], end[:3, 3], atol=1e-4)


@pytest.mark.parametrize(
    "request_",
    [
        {"command": "movej", "v": 20, "joint": [179000, 0, 0, 0, 0, 0]},
        {"command": "movej", "v": 0, "joint": [0] * 6},
        {"command": "movej", "v": 20},
        {"command": "movel", "v": 20, "pose": [2000000, 0, 0, 0, 0, 0]},
        {"command": "movej_p", "v": 20, "pose": [2000000, 0, 0, 0, 0, 0]},
    ],
)
def test_moves_that_cannot_be_done_are_refused_and_nothing_moves(desk, request_):
    assert reply(desk, request_)["receive_state"] is False
    path, ends = run(desk.controller, 0.1)
    assert_allclose(path[-1], HOME)
    assert ends == []


def test_a_second_move_while_one_runs_is_refused_but_the_first_ends_once(desk):
    first = {"command": "movej", "v": 50, "joint": [0, 50000, -120000, 0, -80000, 0]}
    assert reply(desk, first)["receive_state"]
    assert not reply(desk, first)["receive_state"]
    assert len(run(desk.controller, 3.0)[1]) == 1


@pytest.mark.parametrize("name", ["set_arm_stop", "set_arm_slow_stop"])
def test_stop_ends_a_move_short_with_one_false_event(desk, name):
    reply(desk, {"command": "movej", "v": 30, "joint": [0, -10000, -90000, 0, -40000, 0]})
    run(desk.controller, 1.0)
    assert next(iter(reply(desk, {"command": name}).values())) == name
    path, ends = run(desk.controller, 2.0)
    assert [end.reached for end in ends] == [False]
    assert_allclose(path[-1], path[-40], atol=1e-6)
    assert np.abs(path[-1] - np.radians([0, -10, -90, 0, -40, 0])).max() > 0.1


def test_pause_stands_and_continue_arrives(desk):
    goal = [0, -10000, -90000, 0, -40000, 0]
    reply(desk, {"command": "movej", "v": 30, "joint": goal})
    run(desk.controller, 1.0)
    reply(desk, {"command": "set_arm_pause"})
    path, ends = run(desk.controller, 2.0)
    assert_allclose(path[-1], path[-40], atol=1e-6)
    assert ends == []
    reply(desk, {"command": "set_arm_continue"})
    path, ends = run(desk.controller, 6.0)
    assert [end.reached for end in ends] == [True]
    assert_allclose(path[-1], joints_from_wire(goal), atol=2e-4)


def stream(desk, degrees):
    return reply(
        desk, {"command": "movej_canfd", "joint": [round(1000 * d) for d in degrees], "follow": True}
    )


def test_the_stream_is_followed_without_reply_and_its_end_is_a_stop(desk):
    degrees = np.array(HOME_DEG)
    for _ in range(100):
        degrees += np.array([0.0, -0.3, 0.0, 0.0, 0.0, 0.3])
        assert stream(desk, degrees) is None
        path, _ = run(desk.controller, 0.01)
        assert desk.controller.motion is Motion.STREAM
    lag = np.abs(path[-1] - np.radians(degrees)).max()
    assert 0.0 < lag < np.radians(1.5)
    path, ends = run(desk.controller, 1.0)
    assert_allclose(path[-1], np.radians(degrees), atol=1e-4)
    assert desk.controller.motion is Motion.IDLE
    assert ends == []


@pytest.mark.parametrize(
    ("jump", "code"), [((0, 15, 0, 0, 0, 0), OVER_SPEED), ((0, 100, 0, 0, 0, 0), TARGET_OVER_LIMIT)]
)
def test_a_frame_too_far_is_not_followed_and_raises_the_code_until_a_good_one(desk, jump, code):
    stream(desk, np.array(HOME_DEG) + jump)
    path, _ = run(desk.controller, 0.2)
    assert_allclose(path[-1], HOME, atol=1e-9)
    assert parse_sample(datagram(desk.controller, PushSettings()).data, 0.0).errors == (code,)
    stream(desk, HOME_DEG)
    assert desk.controller.health.error == 0


def test_the_push_holds_what_the_state_query_says(desk):
    run(desk.controller, 0.2)
    sample = parse_sample(datagram(desk.controller, PushSettings()).data, 1.0)
    state = reply(desk, {"command": "get_current_arm_state"})["arm_state"]
    assert_allclose(sample.joints, joints_from_wire(state["joint"]))
    assert_allclose(sample.T_base_flange, pose_from_wire(state["pose"]), atol=2e-3)
    assert_allclose(sample.T_base_flange, RM65("6F").flange(sample.joints), atol=2e-5)


def test_zeroing_takes_the_offset_away(desk):
    run(desk.controller, 0.3)
    assert np.linalg.norm(reply(desk, {"command": "get_force_data"})["zero_force_data"][:3]) > 200
    assert reply(desk, {"command": "clear_force_data"})["clear_state"]
    run(desk.controller, 0.1)
    assert np.linalg.norm(reply(desk, {"command": "get_force_data"})["zero_force_data"][:3]) < 300
