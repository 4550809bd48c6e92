"""Segments and clouds as bytes: too large is refused unread, and each refusal is told."""

import numpy as np
import pytest
from bathbot_depthcorr.node import stage_node  # noqa: F401 - chooses the middleware before the first message
from bathbot_localize.messages import cloud_from_surface
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.rm65.ros import intake_node
from bathbot_scrub.rm65.ros.intake_node import Intake
from bathbot_scrub.segment.messages import message_from_segment
from bathbot_scrub.segment.segment import MOST_POSES, Segment
from rclpy.serialization import serialize_message
from std_msgs.msg import Header


class World:
    """Plays the node, its log, the middleware, and the driver with what it sees."""

    def __init__(self, monkeypatch):
        self.most, self.refuse_size, self.lines, self.followed, self.seen = {}, {}, [], [], []
        self.surroundings, self.wrong, self.refused = self, "", []

        def hear(node, kind, topic, qos, most, work, refuse):
            self.most[topic], self.refuse_size[topic] = most, refuse

        monkeypatch.setattr(intake_node, "RawListener", hear)
        self.intake = Intake(self, self, self.lines.append)

    def now(self):
        return 100.0

    def get_logger(self):
        return self

    def warning(self, line, throttle_duration_sec):
        self.lines.append(line)

    def follow(self, segment):
        if self.wrong:
            raise NotReadyError(self.wrong)
        self.followed.append(segment.index)

    def refuse(self, path_id, index, why):
        self.refused.append((path_id, index, why))

    def see(self, points, stamp):
        self.seen.append(len(points))


@pytest.fixture
def world(monkeypatch):
    return World(monkeypatch)


def segment(poses=3, index=0):
    return serialize_message(
        message_from_segment(Segment(7, index, False, "Trunk_skin", np.tile(np.eye(4), (poses, 1, 1)), 0.04))
    )


def cloud(points=5, frame="base_link"):
    return serialize_message(cloud_from_surface(np.zeros((1, points, 3)), Header(frame_id=frame)))


def test_the_largest_segment_is_taken_and_one_pose_more_is_refused(world):
    assert len(segment(MOST_POSES)) <= world.most["scrub_segments"]
    world.intake.follow(segment(MOST_POSES))
    assert (world.followed, world.intake.refused) == ([0], "")
    world.intake.follow(segment(MOST_POSES + 1))
    assert f"{MOST_POSES + 1} poses" in world.intake.refused
    assert world.followed == [0]


def test_what_is_refused_unread_is_told(world):
    assert len(segment(2 * MOST_POSES)) > world.most["scrub_segments"]
    world.refuse_size["scrub_segments"](11_200_000)
    assert "11200000 bytes was refused unread" in world.intake.refused
    assert world.lines == [world.intake.refused]
    assert len(cloud(50_000)) <= world.most["body_cloud"] < len(cloud(200_000))
    world.refuse_size["body_cloud"](12_000_000)
    assert "12000000 bytes was refused unread" in world.lines[1]


def test_a_refusal_of_the_driver_is_told_until_a_segment_is_taken(world):
    world.wrong = "the arm is in state FREE"
    world.intake.follow(segment(index=4))
    assert world.intake.refused == "segment 4 of path 7 refused: the arm is in state FREE"
    assert world.lines == [world.intake.refused]
    assert world.refused == [(7, 4, "the arm is in state FREE")]  # its job is told, too
    world.wrong = ""
    world.intake.follow(segment(index=5))
    assert (world.followed, world.intake.refused) == ([5], "")


@pytest.mark.parametrize("raw", [b"", b"\0\1\0\0", b"\0\1\0\0" + b"\xff" * 200])
def test_bytes_that_are_no_message_are_refused(world, raw):
    world.intake.follow(raw)
    world.intake.see(raw)
    assert ["cannot be read" in line for line in world.lines] == [True, True]
    assert (world.followed, world.seen) == ([], [])


def test_a_cloud_is_seen_and_one_in_another_frame_is_told(world):
    world.intake.see(cloud())
    assert (world.seen, world.lines) == ([5], [])
    world.intake.see(cloud(frame="kitchen"))
    assert world.seen == [5]
    assert "kitchen" in world.lines[0]
