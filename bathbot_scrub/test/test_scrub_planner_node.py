"""The planner node over DDS, with test nodes in place of localiser and arm: their messages are its input."""

import os
import threading
import time

import numpy as np
import pytest
import rclpy
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_localize.messages import cloud_from_surface, pose_from_transform
from bathbot_scrub.arm.branches import nearest
from bathbot_scrub.rm65.arm.kinematics import JOINT_NAMES
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.scrub_planner_node import ScrubPlanner
from bathbot_scrub.segment.messages import segment_from_message
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Header
from std_srvs.srv import Trigger
from synthetic_skin import DISTANCE, cylinder, moved, target

from bathbot_msgs.action import Scrub
from bathbot_msgs.msg import ArmState, ContactTarget, ContactTargets, ScrubSegment

pytestmark = pytest.mark.graph

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# the cylinder of the other tests, carried to where the arm reaches it
TURN = Rotation.from_euler("z", 40, degrees=True).as_matrix()
MOVE = transform_from(TURN, (0.5, 0.0, 0.3)) @ transform_from(translation=(-DISTANCE, 0.0, 0.0))
TARGET = MOVE @ target()
ARM = RM65("6F")
JOINTS = nearest(ARM.solve_head(TARGET), ARM.home, ARM.limits)


class World(rclpy.node.Node):
    """Localiser and arm: publishes 20 times a second; follows a segment in 0.1 s."""

    def __init__(self):
        super().__init__("world")
        self.mode, self.out, self.following = ArmState.FREE, 0.0, True
        self.segments, self.paths, self.told, self.paused = [], [], [], 0
        self.path_id, self.under_head = 0, 0.0
        make = self.create_publisher
        self.arm = make(ArmState, "arm_state", 10)
        self.targets = make(ContactTargets, "contact_targets", 10)
        self.surface = make(PointCloud2, "surface", 5)
        self.head = make(PoseStamped, "tool_pose", 10)
        self.joints = make(JointState, "joint_states", 10)
        self.create_subscription(ScrubSegment, "scrub_segments", self.take, QoSProfile(depth=50))
        self.create_subscription(Path, "planned_path", self.paths.append, LATCHED)
        self.create_subscription(DiagnosticArray, "/diagnostics", self.hear, 10)
        self.create_service(Trigger, "arm/pause", self.pause)
        self.scrub = ActionClient(self, Scrub, "scrub")
        self.create_timer(0.05, self.tick)
        self.create_timer(0.1, self.look)

    def take(self, message):
        if message.path_id != self.path_id:
            self.path_id, self.under_head, self.segments = message.path_id, 0.0, []
        self.segments.append(message)

    def hear(self, message):
        self.told += [status.message for status in message.status if status.name == "scrub_planner"]

    def pause(self, _, response):
        self.paused += 1
        response.success = True
        return response

    def tick(self):
        if self.segments and self.following and self.mode == ArmState.CONTACT:
            self.under_head = min(self.under_head + 0.5, len(self.segments))
        done = bool(self.segments) and self.segments[-1].last and self.under_head >= len(self.segments)
        index = min(int(self.under_head), max(len(self.segments) - 1, 0))
        self.arm.publish(ArmState(
            state=self.mode, connected=True, path_id=self.path_id, segment_index=index, path_done=done,
            segments_queued=len(self.segments) - index, distance_along=0.06 * self.under_head))  # fmt: skip
        header = Header(frame_id="base_link", stamp=self.get_clock().now().to_msg())
        self.head.publish(PoseStamped(header=header, pose=pose_from_transform(TARGET)))
        self.joints.publish(JointState(header=header, name=list(JOINT_NAMES), position=JOINTS.tolist()))

    def look(self):
        header = Header(frame_id="base_link", stamp=self.get_clock().now().to_msg())
        skin = cylinder(noise=0.0005, seed=1)
        skin[..., 0] -= self.out
        if self.mode != ArmState.FREE:
            skin[60:, 80:140] = np.nan
        self.surface.publish(cloud_from_surface(moved(MOVE, skin), header))
        found = ContactTarget(region="Trunk_skin", score=0.9)
        found.pose.pose = pose_from_transform(TARGET)
        self.targets.publish(ContactTargets(header=header, targets=[found]))


class Session:
    """Planner and world, spinning, with an action client for the test."""

    def __init__(self):
        domain = int(os.environ.get("ROS_DOMAIN_ID", 1 + os.getpid() % 100))
        rclpy.init(domain_id=domain)
        self.planner, self.world = ScrubPlanner(), World()
        assert self.planner.autostart()
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.planner)
        self.executor.add_node(self.world)
        self.thread = threading.Thread(target=self.executor.spin, daemon=True)
        self.thread.start()
        self.feedback = []

    def until(self, condition, timeout=20.0):
        end = time.monotonic() + timeout
        while not condition():
            assert time.monotonic() < end, f"not within {timeout} s; last told: {self.world.told[-3:]}"
            time.sleep(0.01)

    def touch(self):
        """Show the skin to the planner while the arm is free, then be in contact.

        What a planner has heard it says on no topic, so that here and below tests look into it.
        """
        inputs = self.planner._session.inputs
        self.until(lambda: inputs.before._surface is not None and inputs.before._targets)
        self.world.mode = ArmState.CONTACT
        self.until(lambda: inputs.before.arm.state == ArmState.CONTACT and inputs.knows_arm)

    def send(self, region="Trunk_skin", max_length=0.0):
        assert self.world.scrub.wait_for_server(10.0)
        goal = Scrub.Goal(region=region, max_length=max_length)
        return self.ask(
            lambda: self.world.scrub.send_goal_async(goal, lambda told: self.feedback.append(told.feedback))
        )

    def result(self, goal):
        return self.ask(goal.get_result_async).result

    def ask(self, call):
        """From the executor's thread: an answer that outruns the client's book-keeping is dropped."""
        asked = self.executor.create_task(call)
        self.until(lambda: asked.done() and asked.result().done())
        return asked.result().result()

    def close(self):
        self.executor.shutdown()
        self.thread.join(5.0)
        self.planner.end()
        self.world.destroy_node()
        rclpy.try_shutdown()


@pytest.fixture
def session():
    session = Session()
    yield session
    session.close()


def test_goal_without_contact_is_refused_in_words(session):
    session.until(lambda: session.planner._session.inputs.before._report is not None)
    result = session.result(session.send())
    assert result.error_code == Scrub.Result.NOT_READY
    assert "not in CONTACT" in result.error_msg
    session.until(lambda: any("not in CONTACT" in line for line in session.world.told))
    assert session.world.segments == []


def test_region_is_scrubbed_to_the_end(session):
    session.touch()
    result = session.result(session.send())
    assert (result.error_code, result.error_msg) == (Scrub.Result.NONE, "")
    segments = session.world.segments
    assert result.segments == len(segments) >= 5
    assert [message.index for message in segments] == list(range(len(segments)))
    assert {message.region for message in segments} == {"Trunk_skin"}
    assert {message.header.frame_id for message in segments} == {"base_link"}
    poses = np.concatenate([segment_from_message(message).T_base_heads for message in segments])
    assert np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1).max() < 0.00201
    assert len(session.world.paths[-1].poses) == pytest.approx(len(poses), abs=2)
    assert 0.5 < session.feedback[-1].fraction <= 1.0
    assert session.feedback[-1].planning_time < 1.0
    session.until(lambda: any("scrubbed 0." in line for line in session.world.told))


def test_cancel_ends_the_goal_and_pauses_the_arm(session):
    session.touch()
    session.world.following = False
    goal = session.send()
    session.until(lambda: len(session.world.segments) == 3)
    busy = session.result(session.send())
    assert (busy.error_code, "another path" in busy.error_msg) == (Scrub.Result.NOT_READY, True)
    session.ask(goal.cancel_goal_async)
    assert session.result(goal).error_code == Scrub.Result.CANCELED
    session.until(lambda: session.world.paused == 1)
    assert len(session.world.segments) == 3


def test_with_a_body_of_long_ago_no_path_is_chosen(session):
    session.touch()
    long_ago = session.world.get_clock().now() - Duration(seconds=9)
    header = Header(frame_id="base_link", stamp=long_ago.to_msg())
    bodies = session.world.create_publisher(PointCloud2, "body_cloud", 1)
    session.until(lambda: bodies.get_subscription_count() > 0)
    bodies.publish(cloud_from_surface(cylinder(), header))
    session.until(lambda: session.planner._session.inputs.knows_body)
    result = session.result(session.send())
    assert result.error_code == Scrub.Result.NOT_READY
    assert "the body was last seen" in result.error_msg
    assert session.world.segments == []


def test_skin_that_moves_away_loses_the_target(session):
    session.touch()
    session.world.following = False
    goal = session.send()
    session.until(lambda: len(session.world.segments) == 3)
    session.world.out = 0.03
    result = session.result(goal)
    assert result.error_code == Scrub.Result.TARGET_LOST
    assert "the skin moved" in result.error_msg
    session.until(lambda: session.world.paused == 1)
    session.world.out, session.world.following = 0.0, True
    assert session.result(session.send(max_length=0.05)).error_code == Scrub.Result.NONE
