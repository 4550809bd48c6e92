from types import SimpleNamespace

import numpy as np
import pytest
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.ros import messages
from bathbot_depthcorr.ros.image_decoding import (
    MessageError,
    colour_from_image,
    depth_from_image,
    pinhole_from_info,
    transform_from_extrinsics,
)
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.testing import assert_allclose, assert_array_equal
from std_msgs.msg import Header


def image(array, encoding, *, pad=0, big=False):
    """An image with `pad` bytes after each row."""
    rows = (
        array.astype(array.dtype.newbyteorder(">" if big else "<")).view(np.uint8).reshape(array.shape[0], -1)
    )
    data = np.pad(rows, ((0, 0), (0, pad)), constant_values=7).tobytes()
    return SimpleNamespace(
        height=array.shape[0], width=array.shape[1], encoding=encoding, step=rows.shape[1] + pad, data=data,
        is_bigendian=int(big),
    )  # fmt: skip


@given(
    mm=hnp.arrays(np.uint16, st.tuples(st.integers(1, 5), st.integers(1, 5))),
    pad=st.integers(0, 3),
    big=st.booleans(),
)
def test_millimetres_become_metres_and_zero_becomes_nan(mm, pad, big):
    depth = depth_from_image(image(mm, "16UC1", pad=pad, big=big))
    assert depth.dtype == np.float32
    assert_array_equal(np.isnan(depth), mm == 0)
    assert_allclose(depth[mm > 0], mm[mm > 0] / 1000.0, rtol=1e-6)


def test_float_depth_keeps_metres_and_drops_what_is_none():
    raw = np.array([[0.5, np.nan, 0.0, -1.0, np.inf]], np.float32)
    assert_array_equal(depth_from_image(image(raw, "32FC1")), [[0.5, np.nan, np.nan, np.nan, np.nan]])


def test_decoding_does_not_write_to_the_message():
    raw = np.array([[0.0, 1.0]], np.float32)
    message = image(raw, "32FC1")
    message.data = bytearray(message.data)
    depth_from_image(message)
    assert message.data == bytearray(raw.tobytes())


def test_bgr_is_turned_to_rgb():
    rgb = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    assert_array_equal(colour_from_image(image(rgb, "rgb8")), rgb)
    assert_array_equal(colour_from_image(image(rgb[..., ::-1], "bgr8", pad=2)), rgb)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"encoding": "rgb8"}, "encoding 'rgb8', expected 16UC1 or 32FC1"),
        ({"data": b"123"}, "3 bytes, expected step >= 8 and 16 bytes"),
        ({"step": 5}, "has step 5"),
        ({"height": 0}, r"image is empty \(4x0\)"),
    ],
)
def test_contradicting_fields_are_refused_in_one_line(change, words):
    message = image(np.ones((2, 4), np.uint16), "16UC1")
    vars(message).update(change)
    with pytest.raises(MessageError, match=words) as caught:
        depth_from_image(message)
    assert "\n" not in str(caught.value)


def test_fisheye_intrinsics_are_refused():
    info = SimpleNamespace(distortion_model="equidistant", d=[0.1] * 4, k=list(range(9)), width=4, height=4)
    with pytest.raises(MessageError, match="equidistant"):
        pinhole_from_info(info)


def test_extrinsics_that_are_no_rotation_are_refused():
    with pytest.raises(MessageError, match="hold no rotation"):
        transform_from_extrinsics(SimpleNamespace(rotation=[0.0] * 9, translation=[0.0] * 3))


def test_ros_messages_round_trip():
    header = Header(frame_id="camera")
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.3, 2.0, (6, 8)).astype(np.float32)
    depth[2, 3] = np.nan
    assert_array_equal(depth_from_image(messages.image_from_depth(depth, header)), depth)
    assert_allclose(depth_from_image(messages.image_mm_from_depth(depth, header)), depth, atol=0.00051)
    assert_array_equal(messages.image_mm_from_depth(np.array([[70.0, np.nan]]), header).data, [0, 0, 0, 0])
    rgb = rng.integers(0, 255, (6, 8, 3), dtype=np.uint8)
    assert_array_equal(colour_from_image(messages.image_from_colour(rgb, header)), rgb)
    camera = Pinhole(848, 480, 425.0, 424.0, 423.0, 241.0, (0.1, 0.2, 0.3, 0.4, 0.5))
    assert pinhole_from_info(messages.info_from_pinhole(camera, header)) == camera
    transform = np.eye(4)
    transform[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    transform[:3, 3] = (-0.059, 0.0, 0.001)
    message = messages.extrinsics_from_transform(transform)
    assert_array_equal(message.rotation, [0, 1, 0, -1, 0, 0, 0, 0, 1])  # column by column
    assert_allclose(transform_from_extrinsics(message), transform)
    assert_allclose(messages.stamp_seconds(messages.stamp_from_seconds(12.75)), 12.75)
