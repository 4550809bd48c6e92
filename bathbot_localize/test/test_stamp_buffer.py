"""Messages kept by stamp: the nearest is found, old ones are forgotten."""

import numpy as np
from bathbot_localize.target.stamp_buffer import StampBuffer


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
