"""The rate of frames, when one is looked at closely, and when the camera is silent."""

import pytest
from bathbot_depthcorr.live.frame_pace import FramePace


def test_the_rate_is_that_since_the_last_count():
    pace = FramePace(100.0)
    pace.count(102.0, 30)
    assert pace.fps == pytest.approx(15.0)
    pace.count(103.0, 90)
    assert pace.fps == pytest.approx(60.0)


def test_the_first_frame_and_one_a_second_are_looked_at_closely():
    pace = FramePace(100.0)
    assert [pace.see(now) for now in (100.1, 100.2, 101.0, 101.2, 101.3)] == [True, False, False, True, False]


def test_a_camera_is_silent_until_its_first_frame_and_3_s_after_its_last():
    pace = FramePace(100.0)
    assert pace.count(101.0, 0)
    pace.see(101.5)
    assert not pace.count(104.4, 1)
    assert pace.count(104.6, 1)
