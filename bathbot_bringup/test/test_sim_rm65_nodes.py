"""The arm's nodes as processes over DDS: `rm65_driver` against an emulator with a wall, and `sim_rm65`."""

import signal

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_bringup.sim.arm.trace import load_trace
from bathbot_depthcorr.node import stage_node  # noqa: F401 - keeps DDS on this machine, before the first context
from bathbot_depthcorr.ros.pose_decoding import transforms_from_poses
from bathbot_localize.messages import pose_from_transform
from bathbot_scrub.rm65.arm.kinematics import JOINT_NAMES
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.segment.messages import message_from_segment
from emulator_cell import AXIS, READY_DEG, TARGET, Wall, segments
from emulator_probe import Probe, driver_node, ended, free_port, node, walled_arm
from numpy.testing import assert_allclose

from bathbot_msgs.action import Approach
from bathbot_msgs.msg import ArmState

pytestmark = pytest.mark.graph


@pytest.fixture(scope="module")
def probe():
    probe = Probe()
    yield probe
    probe.close()


@pytest.fixture(scope="module")
def arm(probe):
    with walled_arm(probe, joint_speed=2.0, joint_acceleration=6.0) as driver:
        yield driver


def segment_message(segment):
    return message_from_segment(segment._replace(spacing=0.002, speed=0.08))


def test_sim_rm65_serves_the_arm_and_tells_the_truth(probe, tmp_path):
    port = free_port()
    simulator = node(
        "bathbot_bringup.sim.arm.sim_rm65_node",
        port=port,
        seed=2,
        scenario="still",
        trace=str(tmp_path / "end.npz"),
    )
    with ended(simulator), ended(driver_node(port=port)):
        probe.until(lambda: probe.state()[2] and {"sim_contact", "tool_pose"} <= set(probe.newest))
        contact, pose = probe.newest["sim_contact"], probe.newest["tool_pose"].pose
        assert contact.header.frame_id == "base_link"
        assert contact.part == ""
        assert contact.compression < 0.0
        true, told = transforms_from_poses([contact.head, pose])
        assert_allclose(true, told, atol=1e-4)
        for text in ("{kind: tea}", "{kind: frozen_force}"):
            probe.say("sim_fault", text)
        asked = tmp_path / "asked.npz"

        def kinds():
            probe.say("sim_trace", str(asked))
            probe.until(asked.exists)
            return load_trace(asked).event_kind.tolist()

        probe.until(lambda: kinds() == ["frozen_force"])
        probe.say("sim_trace", "")
        asked.unlink()
        probe.until(lambda: not kinds())
    probe.newest.clear()
    assert simulator.output.count("unknown fault 'tea'") == 1
    assert len(load_trace(tmp_path / "end.npz").stamp)


def test_a_driver_that_is_interrupted_on_the_skin_leaves_it_first(probe):
    """The true head, as the emulated controller has it, after Ctrl-C to the only driver there is."""
    usual = {"brake_after": 0.15, "stale_after": 2.0, "wait_at_most": 10.0, "home_deg": list(READY_DEG)}
    with Emulator(EmulatorSettings(port=0, joints_deg=READY_DEG), Wall()) as emulator:
        with ended(driver_node(port=emulator.port, joint_speed=2.0, **usual)) as driver:
            probe.until(lambda: probe.state()[2])
            outcome = probe.result(probe.send(probe.goal()).get_result_async())
            assert outcome.status == GoalStatus.STATUS_SUCCEEDED
            assert emulator.truth().contact.compression > 0.0
            driver.send_signal(signal.SIGINT)
        probe.newest.clear()
        away = emulator.truth().T_base_head[:3, 3] - TARGET[:3, 3]
        assert away @ -AXIS > 0.05


def test_without_controller_it_says_so_in_one_line_and_lives(probe):
    with ended(driver_node(port=free_port())) as driver:
        probe.until(lambda: any("cannot reach" in status.message for status in probe.told))
        assert not probe.state()[2]
        outcome = probe.result(probe.send(probe.goal()).get_result_async())
        assert outcome.result.error_code == Approach.Result.NOT_READY
    probe.newest.clear()
    assert driver.output.count("cannot reach the controller") == 1


@pytest.mark.parametrize(
    ("module", "parameters", "told"),
    [
        ("bathbot_scrub.rm65.ros.rm65_driver_node", {"variant": "7F"}, "must be one of B, 6F, 6FB"),
        ("bathbot_bringup.sim.arm.sim_rm65_node", {"scenario": "storm"}, "no scenario 'storm'"),
    ],
)
def test_bad_parameters_end_in_one_line_and_code_2(module, parameters, told):
    process = node(module, **parameters)
    output, _ = process.communicate(timeout=60.0)
    assert process.returncode == 2
    assert told in output
    assert "Traceback" not in output


def test_topics_agree_with_each_other(probe, arm):
    probe.until(
        lambda: {"joint_states", "wrench", "wrench_filtered", "tool_pose", "/tf"} <= set(probe.newest)
    )
    joints, tree = probe.newest["joint_states"], probe.newest["/tf"].transforms
    assert tuple(joints.name) == JOINT_NAMES
    head = RM65("6F").head(np.array(joints.position))
    assert_allclose(transforms_from_poses([probe.newest["tool_pose"].pose])[0], head, atol=1e-4)
    assert probe.newest["tool_pose"].header.frame_id == "base_link"
    assert probe.newest["wrench_filtered"].header.frame_id == "scrub_head"
    chain = np.eye(4)
    for link in tree:
        x, q = link.transform.translation, link.transform.rotation
        pose = pose_from_transform(np.eye(4))
        pose.position.x, pose.position.y, pose.position.z = x.x, x.y, x.z
        pose.orientation = q
        chain = chain @ transforms_from_poses([pose])[0]
    assert [link.child_frame_id for link in tree] == [*(f"Link{i}" for i in range(1, 7)), "scrub_head"]
    assert_allclose(chain, head, atol=1e-4)


def test_goals_that_cannot_be_reached_come_back_with_their_code(probe, arm):
    far = TARGET.copy()
    far[0, 3] += 1.0
    wrong = probe.goal()
    wrong.target.pose.orientation.w += 0.5
    for goal, code in (
        (probe.goal(far), Approach.Result.UNREACHABLE),
        (wrong, Approach.Result.INVALID_TARGET),
        (probe.goal(frame="camera_link"), Approach.Result.INVALID_TARGET),
        (probe.goal(region="Knee"), Approach.Result.INVALID_TARGET),
    ):
        outcome = probe.result(probe.send(goal).get_result_async())
        assert outcome.status == GoalStatus.STATUS_ABORTED
        assert outcome.result.error_code == code
        assert outcome.result.error_msg
    assert probe.state()[0] == ArmState.FREE


def test_cancel_and_stop_end_an_approach(probe, arm):
    goal = probe.send(probe.goal())
    probe.until(lambda: probe.state()[0] == ArmState.APPROACH)
    probe.result(goal.cancel_goal_async())
    outcome = probe.result(goal.get_result_async())
    assert (outcome.status, outcome.result.error_code) == (
        GoalStatus.STATUS_CANCELED,
        Approach.Result.CANCELED,
    )
    probe.until(lambda: probe.state()[0] == ArmState.HOLD)
    again = probe.send(probe.goal())
    probe.until(lambda: probe.state()[0] == ArmState.APPROACH)
    assert probe.call("stop").success
    outcome = probe.result(again.get_result_async())
    assert outcome.result.error_code == Approach.Result.CANCELED
    probe.until(lambda: probe.state()[0] == ArmState.HOLD)


def test_the_whole_job_over_dds(probe, arm):
    goal = probe.send(probe.goal())  # from FREE or, after the tests above, from HOLD
    outcome = probe.result(goal.get_result_async())
    assert (outcome.status, outcome.result.error_code, outcome.result.error_msg) == (
        GoalStatus.STATUS_SUCCEEDED,
        0,
        "",
    )
    assert outcome.result.force > 0.8  # filtered; what felt the skin is faster
    assert outcome.result.contact.header.frame_id == "base_link"
    probe.until(lambda: probe.state()[0] == ArmState.CONTACT)
    for segment in segments():
        probe.segments.publish(segment_message(segment))
    probe.until(lambda: probe.newest["arm_state"].path_done)
    state = probe.newest["arm_state"]
    assert (state.path_id, state.segment_index, state.segments_queued) == (7, 2, 0)
    assert state.force_threshold == 10.0
    assert state.period == pytest.approx(0.01)
    assert 1.0 < state.force < 6.0
    assert not probe.call("home").success
    assert probe.call("retract").success
    probe.until(lambda: probe.state()[:2] == (ArmState.FREE, "retracted"))
    assert probe.call("home").success
    probe.until(lambda: probe.state()[:2] == (ArmState.FREE, "at home"))
    assert "remain" in probe.call("zero_force").message
