"""Arrays to messages and back."""

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_localize.messages import (
    MessageError,
    cloud_from_surface,
    contact_targets_from,
    detections_from_regions,
    message_from_transform,
    regions_from_detections,
    stamped_from_transform,
    surface_from_cloud,
    targets_from_contact,
    transform_from_message,
    transforms_from_tf,
)
from bathbot_localize.regions import SkinRegion
from bathbot_localize.target.target import Target, pose_from_normal
from builtin_interfaces.msg import Time
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import Detection2D, Detection2DArray

HEADER = Header(stamp=Time(sec=12, nanosec=500_000_000), frame_id="base_link")


def over_the_wire(message):
    return deserialize_message(serialize_message(message), type(message))


@settings(max_examples=30, deadline=None)
@given(height=st.integers(0, 6), width=st.integers(0, 6), seed=st.integers(0, 99))
def test_surfaces_come_back_with_their_holes(height, width, seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(height, width, 3)).astype(np.float32)
    points[rng.random((height, width)) < 0.3] = np.nan
    message = over_the_wire(cloud_from_surface(points, HEADER))
    assert message.header.frame_id == "base_link"
    assert (message.height, message.width) == (height, width)
    np.testing.assert_array_equal(surface_from_cloud(message), points.astype(float))


def test_a_cloud_with_padding_and_other_fields_is_read():
    kind = np.dtype({
        "names": ["x", "y", "z", "i"], "formats": ["<f4", "<f4", "<f4", "<u2"],
        "offsets": [0, 4, 8, 16], "itemsize": 20,
    })  # fmt: skip
    data = np.zeros((2, 3), kind)
    data["x"], data["y"], data["z"] = np.arange(6).reshape(2, 3), 7.0, 8.0
    fields = [
        PointField(name=n, offset=4 * i, datatype=PointField.FLOAT32, count=1) for i, n in enumerate("xyz")
    ]
    message = PointCloud2(header=HEADER, height=2, width=3, fields=fields, point_step=20, row_step=64)
    message.data = b"".join(row.tobytes() + b"\0\0\0\0" for row in data)
    points = surface_from_cloud(message)
    np.testing.assert_allclose(points[..., 0], [[0, 1, 2], [3, 4, 5]])
    np.testing.assert_allclose(points[..., 1:], np.broadcast_to([7.0, 8.0], (2, 3, 2)))


def test_a_cloud_that_is_cut_off_or_has_no_xyz_is_refused():
    message = cloud_from_surface(np.zeros((4, 4, 3)), HEADER)
    message.data = message.data[:-1]
    with pytest.raises(MessageError, match="no organised surface"):
        surface_from_cloud(message)
    message = cloud_from_surface(np.zeros((4, 4, 3)), HEADER)
    message.fields = message.fields[:2]
    with pytest.raises(MessageError, match="no organised surface"):
        surface_from_cloud(message)


def test_targets_come_back():
    rng = np.random.default_rng(0)
    covariance = rng.normal(size=(6, 6))
    target = Target(
        "Trunk_skin", 0.75, pose_from_normal((0.5, -0.1, 0.3), (-0.6, 0.8, 0.0)), covariance @ covariance.T,
        (212.5, 101.25), 20.0, 1234,
    )  # fmt: skip
    (back,) = targets_from_contact(over_the_wire(contact_targets_from([target], HEADER)))
    assert back.region == "Trunk_skin"
    assert (back.score, back.pixel, back.radius_px, back.points) == (0.75, (212.5, 101.25), 20.0, 1234)
    np.testing.assert_allclose(back.T_base_target, target.T_base_target, atol=1e-12)
    np.testing.assert_allclose(back.covariance, target.covariance)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_transforms_come_back(seed):
    rng = np.random.default_rng(seed)
    transform = transform_from(Rotation.random(random_state=rng).as_matrix(), rng.normal(size=3))
    np.testing.assert_allclose(
        transform_from_message(message_from_transform(transform)), transform, atol=1e-12
    )


def test_tf_entries_carry_names_and_time():
    message = TFMessage(transforms=[stamped_from_transform(np.eye(4), HEADER, "Link1")])
    (entry,) = transforms_from_tf(over_the_wire(message))
    assert (entry.parent, entry.child, entry.stamp) == ("base_link", "Link1", 12.5)


def test_regions_come_back_and_know_their_centre():
    region = SkinRegion("Hand_skin", 0.5, (10.0, 20.0, 31.0, 60.0))
    (back,) = regions_from_detections(over_the_wire(detections_from_regions([region], HEADER)))
    assert back == region
    assert back.centre == (20.0, 39.5)  # a box over pixels 10..30 has pixel 20 in its middle


def test_a_detection_without_a_class_is_left_out():
    assert regions_from_detections(Detection2DArray(detections=[Detection2D()])) == []
