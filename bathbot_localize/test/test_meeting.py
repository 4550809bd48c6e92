"""Regions meet the depth picture of their time; both are kept by stamp, and old ones forgotten."""

import numpy as np
import pytest
from bathbot_localize.target.meeting import Meeting, NoPictureError, StampBuffer


def test_a_buffer_finds_the_nearest_item_and_forgets_old_ones():
    buffer = StampBuffer(3)
    assert buffer.near(0.0, 1.0) == []
    assert buffer.newest_stamp == -np.inf
    for stamp in (1.0, 2.0, 3.0, 4.0):
        buffer.add(stamp, f"item {stamp}")
    assert buffer.near(2.9, 0.2) == [(3.0, "item 3.0")]
    assert buffer.near(1.0, 0.5) == []
    assert buffer.newest_stamp == 4.0


def test_a_buffer_starts_again_after_a_jump_back_in_time():
    buffer = StampBuffer(5)
    buffer.add(100.0, "old")
    buffer.add(1.0, "new")
    assert buffer.near(100.0, 1.0) == []
    assert buffer.newest_stamp == 1.0


def met(*came: tuple[str, float]) -> list[tuple[str, str]]:
    """What has met after regions ("r") and depth pictures ("d") came in this order."""
    meeting, pairs = Meeting(history=3, tolerance=0.05), []
    for kind, stamp in came:
        add = meeting.add_regions if kind == "r" else meeting.add_depth
        add(stamp, f"{kind}{stamp}")
        pairs += meeting.take()
    return pairs


@pytest.mark.parametrize(
    ("came", "pairs"),
    [
        pytest.param([("r", 1.0)], [], id="regions wait"),
        pytest.param([("r", 1.0), ("d", 1.02)], [("r1.0", "d1.02")], id="regions first"),
        pytest.param([("d", 1.0), ("d", 1.1), ("r", 1.04)], [("r1.04", "d1.0")], id="regions late"),
        pytest.param([("r", 1.0), ("r", 1.2), ("d", 1.2)], [("r1.2", "d1.2")], id="newer regions replace"),
        pytest.param([("r", 1.0), ("d", 1.0), ("d", 1.01)], [("r1.0", "d1.0")], id="once"),
        pytest.param([("d", 0.9), ("r", 1.0)], [], id="the picture is still to come"),
    ],
)
def test_regions_meet_the_picture_of_their_time(came, pairs):
    assert met(*came) == pairs


def test_regions_whose_picture_never_came_are_given_up_with_a_reason():
    meeting = Meeting(history=3, tolerance=0.05)
    meeting.add_regions(1.0, "regions")
    meeting.add_depth(1.2, "later")
    with pytest.raises(NoPictureError, match=r"within 0\.05 s .* depth_history"):
        meeting.take()
    assert meeting.take() == []
