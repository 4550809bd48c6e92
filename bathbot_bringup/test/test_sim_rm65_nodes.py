"""The arm's nodes as processes over DDS: `rm65_driver` against an emulator with a wall, and `sim_rm65` itself."""

import os
import signal
import socket
import subprocess
import sys
import time

import numpy as np
import pytest
import rclpy
from action_msgs.msg import GoalStatus
from bathbot_scrub.rm65.kinematics import JOINT_NAMES, Kinematics
from bathbot_scrub.rm65.messages import pose_message, transforms_from_poses
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, WrenchStamped
from numpy.testing import assert_allclose
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger
from test_emulator_driver import READY_DEG, REGION, TARGET, segments
from tf2_msgs.msg import TFMessage

from bathbot_depthcorr import stage_node  # noqa: F401 - keeps DDS on this machine, before the first context
from bathbot_msgs.action import Approach
from bathbot_msgs.msg import ArmState, ScrubSegment, SimContact

DOMAIN = 1 + os.getpid() % 100
EMULATOR = """
import sys, threading
from bathbot_bringup.sim.emulator import Emulator
from bathbot_bringup.sim.emulator_settings import EmulatorSettings
from test_emulator_driver import READY_DEG, Wall
with Emulator(EmulatorSettings(port=0, joints_deg=READY_DEG), Wall()) as emulator:
    print(emulator.port, flush=True)
    threading.Event().wait()
"""


def start(*command, **options):
    environment = os.environ | {
        "ROS_DOMAIN_ID": str(DOMAIN), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "OMP_NUM_THREADS": "1",
        "PYTHONPATH": os.pathsep.join([os.path.dirname(__file__), os.environ.get("PYTHONPATH", "")]),
    }  # fmt: skip
    return subprocess.Popen([sys.executable, *command], env=environment, text=True, **options)


def node(module, **parameters):
    values = [part for key, value in parameters.items() for part in ("-p", f"{key}:={value}")]
    return start("-m", module, "--ros-args", *values, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


def driver_node(**parameters):
    return node("bathbot_scrub.rm65.rm65_driver_node", udp_port=0, **parameters)


def end(process, kind=signal.SIGINT):
    """Interrupt a process; give its exit code and what it wrote."""
    process.send_signal(kind)
    output, _ = process.communicate(timeout=30.0)
    return process.returncode, output


class Probe:
    """Hears and asks what a test needs; spun by the test itself."""

    def __init__(self):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node("probe", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.newest, self.told = {}, []
        for kind, topic in ((ArmState, "arm_state"), (JointState, "joint_states"), (WrenchStamped, "wrench"),
                            (WrenchStamped, "wrench_filtered"), (PoseStamped, "tool_pose"), (TFMessage, "/tf"),
                            (SimContact, "sim_contact")):  # fmt: skip
            self.node.create_subscription(kind, topic, lambda m, topic=topic: self.newest.update({topic: m}), 10)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", lambda m: self.told.extend(m.status), 10)
        self.segments = self.node.create_publisher(ScrubSegment, "scrub_segments", QoSProfile(depth=50))
        self.approach = ActionClient(self.node, Approach, "approach")
        self.services = {name: self.node.create_client(Trigger, f"arm/{name}")
                         for name in ("stop", "pause", "resume", "retract", "home", "zero_force")}  # fmt: skip

    def until(self, condition, timeout=40.0):
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, f"not in time; arm_state is {self.newest.get('arm_state')}"
            self.executor.spin_once(timeout_sec=0.05)

    def result(self, future):
        self.until(future.done)
        return future.result()

    def call(self, name):
        self.until(self.services[name].service_is_ready)
        return self.result(self.services[name].call_async(Trigger.Request()))

    def state(self):
        message = self.newest.get("arm_state")
        return (message.state, message.reason, message.connected) if message else (None, "", False)

    def goal(self, target=TARGET, region=REGION, frame="base_link", speed=0.05):
        goal = Approach.Goal(region=region, speed=speed)
        goal.target.header.frame_id = frame
        goal.target.pose = pose_message(target)
        return goal

    def send(self, goal):
        self.until(self.approach.server_is_ready)
        return self.result(self.approach.send_goal_async(goal))

    def close(self):
        self.executor.shutdown()
        self.approach.destroy()
        self.node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture(scope="module")
def probe():
    probe = Probe()
    yield probe
    probe.close()


@pytest.fixture(scope="module")
def arm(probe):
    emulator = start("-c", EMULATOR, stdout=subprocess.PIPE)
    driver = driver_node(port=int(emulator.stdout.readline()), stale_after=2.0, joint_speed=2.0,
                         joint_acceleration=6.0, home_deg=list(READY_DEG))  # fmt: skip
    try:
        probe.until(lambda: probe.state()[2])
        yield driver
        code, output = end(driver)
        assert code == 0, output
        assert "Traceback" not in output
    finally:
        for process in (driver, emulator):
            process.kill()
            process.wait()
        probe.newest.clear()


def segment_message(segment):
    message = ScrubSegment(path_id=segment.path_id, index=segment.index, last=segment.last, region=segment.region,
                           poses=[pose_message(T) for T in segment.T_base_heads], spacing=0.002, speed=0.08)  # fmt: skip
    message.header.frame_id = "base_link"
    return message


def test_topics_agree_with_each_other(probe, arm):
    probe.until(lambda: {"joint_states", "wrench", "wrench_filtered", "tool_pose", "/tf"} <= set(probe.newest))
    joints, tree = probe.newest["joint_states"], probe.newest["/tf"].transforms
    assert tuple(joints.name) == JOINT_NAMES
    head = Kinematics("6F").head(np.array(joints.position))
    assert_allclose(transforms_from_poses([probe.newest["tool_pose"].pose])[0], head, atol=1e-4)
    assert probe.newest["tool_pose"].header.frame_id == "base_link"
    assert probe.newest["wrench_filtered"].header.frame_id == "scrub_head"
    chain = np.eye(4)
    for link in tree:
        x, q = link.transform.translation, link.transform.rotation
        pose = pose_message(np.eye(4))
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
    for goal, code in ((probe.goal(far), Approach.Result.UNREACHABLE), (wrong, Approach.Result.INVALID_TARGET),
                       (probe.goal(frame="camera_link"), Approach.Result.INVALID_TARGET),
                       (probe.goal(region="Knee"), Approach.Result.INVALID_TARGET)):  # fmt: skip
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
    assert (outcome.status, outcome.result.error_code) == (GoalStatus.STATUS_CANCELED, Approach.Result.CANCELED)
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
    assert (outcome.status, outcome.result.error_code, outcome.result.error_msg) == (GoalStatus.STATUS_SUCCEEDED, 0, "")
    assert outcome.result.force >= 1.0
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


def test_without_controller_it_says_so_in_one_line_and_lives(probe):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    driver = driver_node(port=port)
    probe.until(lambda: any("cannot reach" in status.message for status in probe.told))
    assert not probe.state()[2]
    outcome = probe.result(probe.send(probe.goal()).get_result_async())
    assert outcome.result.error_code == Approach.Result.NOT_READY
    code, output = end(driver, signal.SIGTERM)
    assert code == 0, output
    assert output.count("cannot reach the controller") == 1
    assert "Traceback" not in output


@pytest.mark.parametrize(
    ("module", "parameters", "told"),
    [
        ("bathbot_scrub.rm65.rm65_driver_node", {"variant": "7F"}, "known are B, 6F, 6FB"),
        ("bathbot_scrub.rm65.rm65_driver_node", {"force_limits": "/nowhere.yaml"}, "cannot read force limits"),
        ("bathbot_bringup.sim.sim_rm65_node", {"scenario": "storm"}, "no scenario 'storm'"),
    ],
)
def test_bad_parameters_end_in_one_line_and_code_2(module, parameters, told):
    process = node(module, **parameters)
    output, _ = process.communicate(timeout=60.0)
    assert process.returncode == 2
    assert told in output
    assert "Traceback" not in output


def test_sim_rm65_serves_the_arm_and_tells_the_truth(probe):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    simulator = node("bathbot_bringup.sim.sim_rm65_node", port=port, seed=2, scenario="still")
    driver = driver_node(port=port)
    try:
        probe.until(lambda: probe.state()[2] and "sim_contact" in probe.newest)
        contact = probe.newest["sim_contact"]
        assert contact.header.frame_id == "base_link"
        assert contact.part == ""
        assert contact.compression < 0.0
        probe.until(lambda: "tool_pose" in probe.newest)
        assert_allclose(transforms_from_poses([contact.head])[0],
                        transforms_from_poses([probe.newest["tool_pose"].pose])[0], atol=1e-4)  # fmt: skip
    finally:
        code, output = end(simulator)
        driver.kill()
        driver.wait()
    assert code == 0, output
    assert "Traceback" not in output
