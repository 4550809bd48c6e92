"""Segments to messages and back, as the planner sends and the driver takes them."""

import numpy as np
import pytest
from bathbot_scrub.arm.errors import InvalidPoseError
from bathbot_scrub.rm65.ros.messages import checked_segment
from bathbot_scrub.segment.messages import message_from_segment, segment_from_message
from bathbot_scrub.segment.segment import Segment
from numpy.testing import assert_allclose
from synthetic_skin import somewhere

POSES = np.array([somewhere(index) for index in range(4)])
SEGMENT = Segment(77, 3, True, "Trunk_skin", POSES, 0.04, 0.002, 12.345678912)


@pytest.mark.parametrize("read", [segment_from_message, checked_segment], ids=["planner", "driver"])
def test_a_segment_is_read_as_it_was_written(read):
    back = read(message_from_segment(SEGMENT))
    assert (back.path_id, back.index, back.last, back.region) == (77, 3, True, "Trunk_skin")
    assert (back.speed, back.spacing) == (0.04, 0.002)
    assert back.stamp == pytest.approx(SEGMENT.stamp, abs=1e-8)
    assert_allclose(back.T_base_heads, POSES, atol=1e-12)


def test_its_poses_are_in_the_base_frame_and_may_be_none():
    message = message_from_segment(SEGMENT._replace(T_base_heads=POSES[:0]))
    assert message.header.frame_id == "base_link"
    assert checked_segment(message).T_base_heads.shape == (0, 4, 4)


@pytest.mark.parametrize(("field", "value", "why"), [
    ("position", np.nan, "pose 2 is not finite"), ("orientation", np.nan, "pose 2 is not finite"),
    ("orientation", 3.0, "pose 2 .*not 1"),
])  # fmt: skip
def test_the_driver_refuses_poses_that_are_none(field, value, why):
    message = message_from_segment(SEGMENT)
    getattr(message.poses[2], field).x = value
    with pytest.raises(InvalidPoseError, match=why):
        checked_segment(message)


def test_the_driver_refuses_another_frame():
    message = message_from_segment(SEGMENT)
    message.header.frame_id = "camera_link"
    with pytest.raises(InvalidPoseError, match="segment 3 is in frame 'camera_link'"):
        checked_segment(message)
