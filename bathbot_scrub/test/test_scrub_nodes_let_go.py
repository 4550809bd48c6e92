"""Driver and planner let go of all they made, and can begin anew."""

import os
import threading

import pytest
import rclpy
from bathbot_scrub.rm65.ros.rm65_driver_node import Rm65Driver
from bathbot_scrub.scrub_planner_node import ScrubPlanner
from rclpy.lifecycle import TransitionCallbackReturn

pytestmark = pytest.mark.graph
NOBODY = ["--ros-args", "-p", "rm65_driver:port:=18079", "-p", "rm65_driver:udp_port:=0"]  # answers there


@pytest.fixture
def context():
    rclpy.init(args=["test", *NOBODY], domain_id=int(os.environ.get("ROS_DOMAIN_ID", 1 + os.getpid() % 100)))
    yield
    rclpy.try_shutdown()


@pytest.mark.parametrize("kind", [Rm65Driver, ScrubPlanner])
def test_what_a_transition_makes_ends_with_the_one_that_undoes_it(context, kind):
    node = kind()

    def held():
        ends = (node.publishers, node.subscriptions, node.services, node.clients, node.timers)
        return [len(list(end)) for end in ends]

    def step(transition):
        assert transition() == TransitionCallbackReturn.SUCCESS
        return held(), threading.active_count()

    new = held(), threading.active_count()
    for _ in range(2):
        ready = step(node.trigger_configure)
        active = step(node.trigger_activate)
        assert active[0] != ready[0] != new[0]
        assert step(node.trigger_deactivate) == ready
        assert step(node.trigger_cleanup) == new
    node.end()
