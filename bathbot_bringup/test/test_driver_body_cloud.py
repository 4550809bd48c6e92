"""The driver node among things the camera sees, over DDS: ways that would meet them are refused."""

import numpy as np
import pytest
from bathbot_depthcorr.node.stage_node import LATCHED
from bathbot_localize.messages import cloud_from_surface
from bathbot_scrub.rm65.arm.urdf import urdf
from emulator_cell import AXIS, TARGET
from emulator_probe import Probe, walled_arm
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header, String

from bathbot_msgs.action import Approach
from bathbot_msgs.msg import ArmState

pytestmark = pytest.mark.graph


class BodyProbe(Probe):
    """Shows the driver a cloud."""

    def __init__(self):
        super().__init__()
        self.clouds = self.node.create_publisher(PointCloud2, "body_cloud", 1)

    def show(self, *points, age=0):
        stamp = self.node.get_clock().now().to_msg()
        stamp.sec -= age
        header = Header(frame_id="base_link", stamp=stamp)
        self.until(lambda: self.clouds.get_subscription_count() == 1)
        self.clouds.publish(cloud_from_surface(np.array(points)[None], header))

    def body(self):
        """What the newest diagnostics say of the body."""
        told = [status for status in self.told if status.name == "rm65_driver" and status.values]
        return next((pair.value for pair in told[-1].values if pair.key == "body"), "") if told else ""


@pytest.fixture(scope="module")
def probe():
    probe = BodyProbe()
    with walled_arm(probe, body_max_age=10.0):
        yield probe
    probe.close()


def test_without_a_cloud_it_says_so_and_describes_itself(probe):
    told = []
    probe.node.create_subscription(
        String, "robot_description", lambda message: told.append(message.data), LATCHED
    )
    probe.until(lambda: told and "no body cloud" in probe.body())
    assert told == [urdf("6F")]


def test_a_hand_before_the_target_stops_the_approach_before_it_begins(probe):
    probe.show(TARGET[:3, 3] - 0.08 * AXIS, TARGET[:3, 3])
    probe.until(lambda: probe.body().startswith("2 points"))
    outcome = probe.result(probe.send(probe.goal()).get_result_async()).result
    assert outcome.error_code == Approach.Result.UNREACHABLE
    assert "scrub_head would" in outcome.error_msg
    assert "the body at (" in outcome.error_msg
    assert probe.state()[0] == ArmState.FREE


def test_a_body_of_long_ago_is_not_approached(probe):
    probe.show(TARGET[:3, 3], age=100)
    probe.until(lambda: "too old" in probe.body())
    outcome = probe.result(probe.send(probe.goal()).get_result_async()).result
    assert outcome.error_code == Approach.Result.NOT_READY
    assert "last seen" in outcome.error_msg


def test_skin_at_the_target_is_what_the_arm_came_for(probe):
    probe.show(TARGET[:3, 3])
    probe.until(lambda: probe.body().startswith("1 points"))
    goal = probe.send(probe.goal())
    probe.until(lambda: probe.state()[0] == ArmState.APPROACH)
    probe.result(goal.cancel_goal_async())
    assert probe.result(goal.get_result_async()).result.error_code == Approach.Result.CANCELED


def test_a_hand_that_comes_into_the_way_of_an_arm_that_moves_stops_it(probe):
    probe.show(TARGET[:3, 3])
    probe.until(lambda: probe.body().startswith("1 points"))
    goal = probe.send(probe.goal())
    probe.until(lambda: probe.state()[0] == ArmState.APPROACH)
    probe.show(TARGET[:3, 3], TARGET[:3, 3] - 0.075 * AXIS)
    outcome = probe.result(goal.get_result_async()).result
    assert outcome.error_code == Approach.Result.CANCELED
    assert "the person has moved into the way" in outcome.error_msg
    probe.until(lambda: probe.state()[0] == ArmState.HOLD)
