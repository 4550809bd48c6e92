"""Messages taken as bytes, over real DDS."""

import os
import time

import pytest
import rclpy
from bathbot_depthcorr.node.dds.participant_node import joining
from bathbot_depthcorr.node.endpoints_node import EndpointOwner
from bathbot_depthcorr.node.lifetime import Lifetime
from bathbot_depthcorr.node.raw_subscription_node import RawSubscription
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from std_msgs.msg import String

pytestmark = pytest.mark.graph


@pytest.fixture
def heard():
    """A node, two publishers of a topic, and a subscription that takes messages of 40 bytes at most."""
    context = rclpy.Context()
    context.init(domain_id=1 + os.getpid() % 100)
    with joining(context):
        node = EndpointOwner("ear", context=context)
    node.lifetime = Lifetime()
    subscription = RawSubscription(node, String, "words", QoSProfile(depth=5), 40)
    publishers = [node.create_publisher(String, "words", 10) for _ in range(2)]
    deadline = time.monotonic() + 10.0
    while any(one.get_subscription_count() == 0 for one in publishers):
        assert time.monotonic() < deadline
        time.sleep(0.01)
    yield node, subscription, publishers
    node.lifetime.close()
    node.destroy_node()
    context.try_shutdown()


def all_of(subscription, count):
    """What comes, in order; fails where it does not come."""
    found = []
    while len(found) < count:
        assert subscription.waiting(5.0)
        while (taken := subscription.take()) is not None:
            found.append(taken)
    return found


def test_what_was_sent_comes_with_when_by_whom_and_which_one(heard):
    _, subscription, (one, other) = heard
    before = time.time_ns()
    for word in ("a", "b"):
        one.publish(String(data=word))
    other.publish(String(data="c"))
    found = all_of(subscription, 3)
    said = {(deserialize_message(taken.data, String).data, taken.number) for taken in found}
    assert said == {("a", 1), ("b", 2), ("c", 1)}
    assert len({taken.publisher for taken in found}) == 2
    for taken in found:
        assert before <= taken.published <= time.time_ns()


def test_who_waits_is_woken_and_where_nothing_comes_is_not(heard):
    _, subscription, (one, _) = heard
    assert not subscription.waiting(0.05)
    one.publish(String(data="now"))
    begun = time.monotonic()
    assert subscription.waiting(5.0)
    assert time.monotonic() - begun < 1.0
    assert not subscription.waiting(0.05), "it tells once"
    subscription.remind()
    assert subscription.waiting(0.05)
    assert subscription.take()
    assert subscription.take() is None


def test_what_is_too_large_is_dropped_and_its_size_told(heard):
    _, subscription, (one, _) = heard
    one.publish(String(data="x" * 100))
    (taken,) = all_of(subscription, 1)
    assert (taken.data, taken.size) == (b"", 4 + 4 + 101)


def test_of_more_than_its_depth_the_newest_are_left_and_the_count_tells_the_gap(heard):
    _, subscription, (one, _) = heard
    for number in range(20):
        one.publish(String(data=str(number)))
    time.sleep(0.3)
    found = all_of(subscription, 5)
    assert [taken.number for taken in found] == [16, 17, 18, 19, 20]


def test_nothing_stays_open(heard):
    node, subscription, (one, _) = heard
    event = subscription.fileno()
    node.lifetime.close()
    one.publish(String(data="too late"))
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(event)
