"""The body cloud as the driver reads it."""

import time

import numpy as np
import pytest
from bathbot_localize.messages import cloud_from_surface
from bathbot_scrub.rm65.errors import InvalidPoseError
from bathbot_scrub.rm65.ros.messages import body_from_cloud
from builtin_interfaces.msg import Time
from numpy.testing import assert_allclose
from std_msgs.msg import Header

POINTS = np.random.default_rng(0).uniform(-1.0, 1.0, (1, 40, 3))


def cloud(points=POINTS, frame="base_link"):
    return cloud_from_surface(points, Header(frame_id=frame, stamp=Time(sec=100)))


def test_points_and_age_come_through():
    points, stamp = body_from_cloud(cloud(), 102.5)
    assert_allclose(points, POINTS[0], atol=1e-6)
    assert time.monotonic() - stamp == pytest.approx(2.5, abs=0.2)


def test_a_stamp_of_the_future_makes_it_no_younger():
    assert body_from_cloud(cloud(), 50.0)[1] <= time.monotonic()


def test_points_that_are_none_are_left_out():
    holes = POINTS.copy()
    holes[0, :7, 1] = np.nan
    assert len(body_from_cloud(cloud(holes), 100.0)[0]) == 33


def test_another_frame_and_other_data_are_refused():
    with pytest.raises(InvalidPoseError, match="must be in base_link"):
        body_from_cloud(cloud(frame="camera"), 100.0)
    short = cloud()
    short.data = short.data[:50]
    with pytest.raises(InvalidPoseError, match="cannot be read"):
        body_from_cloud(short, 100.0)
