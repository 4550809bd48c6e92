"""What the driver reads and answers: the body cloud, how an approach ended, what is not installed."""

import sys
import time

import numpy as np
import pytest
from bathbot_depthcorr.errors import BathbotError
from bathbot_localize.messages import cloud_from_surface
from bathbot_scrub.arm.errors import ArmSettingsError, InvalidPoseError, JointLimitError, NoContactError
from bathbot_scrub.rm65.motion.approach import Touch
from bathbot_scrub.rm65.ros.messages import approach_result, body_from_cloud
from bathbot_scrub.rm65.ros.vendor.installed import vendor_topics
from builtin_interfaces.msg import Time
from numpy.testing import assert_allclose
from std_msgs.msg import Header
from synthetic_skin import somewhere

from bathbot_msgs.action import Approach

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


def test_an_approach_that_ended_in_contact_tells_where_and_how_hard():
    result = approach_result(Touch(somewhere(1), 3.5), Time(sec=7))
    assert (result.error_code, result.error_msg, result.force) == (Approach.Result.NONE, "", 3.5)
    assert (result.contact.header.frame_id, result.contact.header.stamp.sec) == ("base_link", 7)
    assert result.contact.pose.position.x == pytest.approx(somewhere(1)[0, 3])


@pytest.mark.parametrize(("error", "code"), [
    (NoContactError("nothing felt"), Approach.Result.NO_CONTACT),
    (JointLimitError("angle", 3, 3.0, 2.4), Approach.Result.UNREACHABLE),
    (BathbotError("ZeroDivisionError: division by zero"), Approach.Result.NOT_READY),
])  # fmt: skip
def test_an_approach_that_failed_tells_why(error, code):
    result = approach_result(error, Time())
    assert (result.error_code, result.error_msg) == (code, str(error))


def test_without_the_vendors_messages_its_topics_are_refused_with_the_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "rm_ros_interfaces", None)
    monkeypatch.setitem(sys.modules, "rm_ros_interfaces.msg", None)
    monkeypatch.delitem(sys.modules, "bathbot_scrub.rm65.ros.vendor.vendor_topics_node", raising=False)
    monkeypatch.delitem(sys.modules, "bathbot_scrub.rm65.ros.vendor.messages", raising=False)
    with pytest.raises(ArmSettingsError, match="build rm_ros_interfaces"):
        vendor_topics(None, None)
