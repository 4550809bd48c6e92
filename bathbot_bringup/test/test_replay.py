import os
import subprocess
import sys

import pytest
from bags import write_bag
from bathbot_bringup.bag.replaying.replayer import (
    ClockHands,
    Message,
    choose_topics,
    has_pictures,
    lost,
    messages_of,
    pace,
    wait_for_listeners,
)
from bathbot_bringup.errors import BagError
from bathbot_bringup.graph.processes import node_environment
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Image

from bathbot_msgs.msg import ArmState, ContactTarget, ContactTargets

KINDS = {
    "/arm_state": ("bathbot_msgs/msg/ArmState", ArmState()),
    "/contact_targets": (
        "bathbot_msgs/msg/ContactTargets", ContactTargets(targets=[ContactTarget(region="Trunk_skin")] * 2),
    ),
    "/camera/camera/color/image_raw": ("sensor_msgs/msg/Image", Image(data=b"123")),
    "/camera/camera/depth/image_rect_raw": ("sensor_msgs/msg/Image", Image(data=b"12")),
    "/rosout": ("rcl_interfaces/msg/Log", None),
}  # fmt: skip


def bag_of(target, *topics, count=40):
    held = [(topic, *KINDS[topic]) for topic in topics]
    rows = [
        (topic, kind, 10**9 + 50_000_000 * index, message)
        for topic, kind, message in held
        if message is not None
        for index in range(count)
    ]
    return write_bag(target, rows, [(topic, kind) for topic, kind, _ in held])


def names(topics):
    return {topic.name for topic in topics}


def test_with_pictures_the_pipelines_own_topics_are_made_anew(tmp_path):
    bag = bag_of(tmp_path / "bag", *KINDS)
    assert names(choose_topics(bag, True)) == set(KINDS) - {"/contact_targets", "/rosout"}
    assert names(choose_topics(bag, False)) == set(KINDS) - {"/rosout"}


def test_without_pictures_everything_is_published(tmp_path):
    bag = bag_of(tmp_path / "bag", "/arm_state", "/contact_targets")
    assert names(choose_topics(bag, True)) == {"/arm_state", "/contact_targets"}


def test_what_was_not_heard_again_is_lost_whatever_else_was_heard(tmp_path):
    topics = choose_topics(bag_of(tmp_path / "bag", "/arm_state", "/camera/camera/color/image_raw"), False)
    assert lost(topics, {"/arm_state": 38, "/surface": 9}) == {"/arm_state": 2}
    assert lost(topics, {"/arm_state": 40}) == {}


def test_an_empty_bag_says_so(tmp_path):
    with pytest.raises(BagError, match="holds no messages"):
        choose_topics(bag_of(tmp_path / "bag"), True)


def test_one_kind_of_picture_is_not_enough():
    assert not has_pictures(["/camera/camera/color/image_raw"])
    assert has_pictures(["/left/camera/color/image_raw", "/left/camera/depth/image_rect_raw"])


def test_messages_come_in_order_and_whole(tmp_path):
    bag = bag_of(tmp_path / "bag", "/arm_state", "/contact_targets")
    messages = list(messages_of(bag, choose_topics(bag, True)))
    assert len(messages) == 80
    assert [message.time for message in messages] == sorted(message.time for message in messages)
    targets = next(message for message in messages if message.topic == "/contact_targets")
    assert deserialize_message(targets.data, ContactTargets) == KINDS["/contact_targets"][1]


@settings(deadline=None)
@given(steps=st.lists(st.integers(0, 10**9), max_size=20), rate=st.floats(0.1, 10.0))
def test_messages_are_given_when_they_are_due(steps, rate):
    clock, given_at = [0.0], []
    stamps = [10**18 + sum(steps[: i + 1]) for i in range(len(steps))]

    def wait(seconds):
        clock[0] += seconds
        return False

    for message in pace((Message("/x", stamp, b"") for stamp in stamps), rate, wait, lambda: clock[0]):
        given_at.append((message.time, clock[0]))
    for stamp, at in given_at:
        assert at == pytest.approx((stamp - stamps[0]) * 1e-9 / rate, abs=1e-6)
    assert len(given_at) == len(stamps)


def test_the_clock_moves_with_the_first_message_in_steps_and_after_a_jump_back():
    hands, begun = ClockHands(), 1_000_000_000
    stamps = [begun, begun + 4_999_999, begun + 5_000_000, begun + 6_000_000, begun, begun + 1]
    assert [hands.move(stamp) for stamp in stamps] == [True, False, True, False, True, False]


@pytest.mark.parametrize(
    ("heard_after", "patience", "waited"),
    [
        pytest.param(0, 5.0, 1.1, id="others get a second to follow"),
        pytest.param(20, 5.0, 2.0, id="the first listener comes late"),
        pytest.param(999, 5.0, 5.0, id="nobody comes"),
        pytest.param(0, 0.0, 0.0, id="no patience"),
    ],
)
def test_listeners_are_waited_for(heard_after, patience, waited):
    waits: list[float] = []

    def wait(seconds: float) -> bool:
        waits.append(seconds)
        return False

    wait_for_listeners(lambda: len(waits) >= heard_after, patience, wait)
    assert sum(waits) == pytest.approx(waited, abs=0.11)


def test_waiting_for_listeners_can_be_ended():
    wait_for_listeners(lambda: False, 60.0, lambda seconds: True)


def test_a_replay_can_be_ended():
    messages = (Message("/x", stamp, b"") for stamp in range(10))
    assert list(pace(messages, 1.0, lambda seconds: True)) == []


@pytest.mark.graph
def test_a_bag_without_pictures_is_published_and_counted(tmp_path):
    """The real replayer in a process of its own, heard over DDS."""
    bag = bag_of(tmp_path / "bag", "/arm_state", "/contact_targets")
    command = [sys.executable, "-m", "bathbot_bringup.command.cli", "replay", str(bag)]
    environment = node_environment(tmp_path) | {"ROS_DOMAIN_ID": str(1 + os.getpid() % 100)}
    outcome = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)
    assert (outcome.returncode, outcome.stderr) == (0, "")
    assert "holds no pictures" in outcome.stdout
    counts = {
        line.split(maxsplit=1)[1]: int(line.split()[0])
        for line in outcome.stdout.splitlines()
        if "  /" in line
    }
    assert counts["/arm_state"] >= 38
    assert counts["/contact_targets: Trunk_skin"] == 2 * counts["/contact_targets"]
