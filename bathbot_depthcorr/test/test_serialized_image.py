import struct

import numpy as np
import pytest
from bathbot_depthcorr.ros.image_decoding import depth_from_image
from bathbot_depthcorr.ros.messages import (
    header_of,
    image_from_depth,
    image_mm_from_depth,
    stamp_from_seconds,
)
from bathbot_depthcorr.ros.serialized_image import SerializedImageError, read_image, stamp_of
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal
from rclpy.serialization import serialize_message
from std_msgs.msg import Header


def depth_of(rows, columns, seed=0):
    depth = np.random.default_rng(seed).uniform(0.3, 4.0, (rows, columns)).astype(np.float32)
    depth[0, 0] = np.nan
    return depth


@settings(max_examples=60, deadline=None)
@given(
    frame=st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=30),
    size=st.tuples(st.integers(1, 9), st.integers(1, 9)),
    seconds=st.floats(0.0, 2e9),
    make=st.sampled_from([image_from_depth, image_mm_from_depth]),
)
def test_what_was_serialized_is_read_back(frame, size, seconds, make):
    message = make(depth_of(*size), Header(stamp=stamp_from_seconds(seconds), frame_id=frame))
    data = bytes(serialize_message(message))
    image = read_image(data)
    assert header_of(image) == message.header
    for name in ("height", "width", "encoding", "is_bigendian", "step"):
        assert getattr(image, name) == getattr(message, name)
    assert_array_equal(depth_from_image(image), depth_from_image(message))
    assert abs(stamp_of(data) - seconds) < 1e-6


def test_the_pixels_are_a_view_of_the_bytes():
    data = bytearray(serialize_message(image_mm_from_depth(depth_of(4, 6), Header(frame_id="camera"))))
    image = read_image(data)
    data[-2:] = (1234).to_bytes(2, "little")
    assert depth_from_image(image)[-1, -1] == np.float32(1.234)


def test_the_other_byte_order_by_hand():
    head = struct.pack(">iII4sIII", 7, 9, 4, b"cam\0", 1, 1, 6) + b"16UC1\0" + struct.pack(">BxI", 1, 2)
    image = read_image(b"\0\0\0\0" + head + struct.pack(">I", 2) + (750).to_bytes(2, "big"))
    assert (image.header.stamp, image.header.frame_id) == ((7, 9), "cam")
    assert depth_from_image(image) == np.float32(0.75)


@settings(max_examples=40, deadline=None)
@given(length=st.integers(0, 100))
def test_cut_off_anywhere_is_one_line(length):
    data = bytes(serialize_message(image_mm_from_depth(depth_of(4, 6), Header(frame_id="camera"))))
    with pytest.raises(SerializedImageError, match=r"is cut off|are no CDR") as caught:
        read_image(data[: min(length, len(data) - 1)])
    assert "\n" not in str(caught.value)


def test_something_else_is_refused():
    with pytest.raises(SerializedImageError, match="5 bytes are no CDR message"):
        read_image(b"hello")
