"""Processes, and a node that hears and asks, for tests of the arm over DDS."""

import os
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager

import rclpy
from bathbot_depthcorr.node import stage_node  # noqa: F401 - keeps DDS on this machine, before the first context
from bathbot_localize.messages import pose_from_transform
from diagnostic_msgs.msg import DiagnosticArray
from emulator_cell import READY_DEG, REGION, TARGET
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from bathbot_msgs.action import Approach
from bathbot_msgs.msg import ArmState, ScrubSegment, SimContact

DOMAIN = 1 + os.getpid() % 100
DRIVER_TOPICS = (
    (ArmState, "arm_state"),
    (JointState, "joint_states"),
    (WrenchStamped, "wrench"),
    (WrenchStamped, "wrench_filtered"),
    (PoseStamped, "tool_pose"),
    (TFMessage, "/tf"),
)
EMULATOR = """
import threading
from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from emulator_cell import READY_DEG, Wall
with Emulator(EmulatorSettings(port=0, joints_deg=READY_DEG), Wall()) as emulator:
    print(emulator.port, flush=True)
    threading.Event().wait()
"""


def start(*command, **options):
    environment = os.environ | {
        "ROS_DOMAIN_ID": str(DOMAIN),
        "OMP_NUM_THREADS": "1",
        "PYTHONPATH": os.pathsep.join([os.path.dirname(__file__), os.environ.get("PYTHONPATH", "")]),
    }
    return subprocess.Popen([sys.executable, *command], env=environment, text=True, **options)


def node(module, **parameters):
    values = [part for key, value in parameters.items() for part in ("-p", f"{key}:={value}")]
    return start("-m", module, "--ros-args", *values, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


def driver_node(**parameters):
    return node("bathbot_scrub.rm65.ros.rm65_driver_node", udp_port=0, **parameters)


@contextmanager
def ended(process):
    """Interrupt a process at the end: it must leave in order. A killed one would haunt the graph."""
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.output, _ = process.communicate(timeout=30.0)
        finally:
            process.kill()
    assert process.returncode == 0, process.output
    assert "Traceback" not in process.output


@contextmanager
def walled_arm(probe, **parameters):
    """The driver's node against an emulated arm before a wall, connected as the probe hears it."""
    emulator = start("-c", EMULATOR, stdout=subprocess.PIPE)
    try:
        # the machine may be busy, hence the long deadlines
        usual = {"brake_after": 0.15, "stale_after": 2.0, "wait_at_most": 10.0, "home_deg": list(READY_DEG)}
        driver = driver_node(port=int(emulator.stdout.readline()), **usual | parameters)
        with ended(driver):
            probe.until(lambda: probe.state()[2])
            yield driver
    finally:
        emulator.kill()
        emulator.wait()


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        return taken.getsockname()[1]


class Probe:
    """Hears and asks what a test needs; spun by the test itself."""

    def __init__(self):
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=DOMAIN)
        self.node = rclpy.create_node("probe", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.newest, self.told = {}, []
        for kind, topic in (*DRIVER_TOPICS, (SimContact, "sim_contact")):
            self.node.create_subscription(
                kind, topic, lambda m, topic=topic: self.newest.update({topic: m}), 10
            )
        self.node.create_subscription(
            DiagnosticArray, "/diagnostics", lambda m: self.told.extend(m.status), 10
        )
        self.segments = self.node.create_publisher(ScrubSegment, "scrub_segments", QoSProfile(depth=50))
        self.talk = {
            topic: self.node.create_publisher(String, topic, 10) for topic in ("sim_fault", "sim_trace")
        }
        self.approach = ActionClient(self.node, Approach, "approach")
        self.services = {
            name: self.node.create_client(Trigger, f"arm/{name}")
            for name in ("stop", "pause", "resume", "retract", "home", "zero_force")
        }

    def until(self, condition, timeout=40.0):
        deadline = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < deadline, f"not in time; arm_state is {self.newest.get('arm_state')}"
            self.executor.spin_once(timeout_sec=0.05)

    def say(self, topic, data):
        """Publish a String to the one node that hears it."""
        self.until(lambda: self.talk[topic].get_subscription_count() == 1)
        self.talk[topic].publish(String(data=data))

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
        goal.target.pose = pose_from_transform(target)
        return goal

    def send(self, goal):
        self.until(self.approach.server_is_ready)
        settled = time.monotonic() + 0.5  # a server that has not found its client yet loses the answer
        self.until(lambda: time.monotonic() > settled)
        return self.result(self.approach.send_goal_async(goal))

    def close(self):
        self.executor.shutdown()
        self.approach.destroy()
        self.node.destroy_node()
        self.context.try_shutdown()
