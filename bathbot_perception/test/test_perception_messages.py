import numpy as np
import pytest
from bathbot_perception.classes import LABELS, SKIN_CLASSES
from bathbot_perception.errors import PictureError
from bathbot_perception.messages import (
    DetectionMessages,
    colour_from_image,
    label_info,
    regions_from_detections,
)
from bathbot_perception.regions import Region
from builtin_interfaces.msg import Time
from hypothesis import given
from hypothesis import strategies as st
from sensor_msgs.msg import Image
from std_msgs.msg import Header

coordinate = st.floats(0, 2000, width=32)
regions = st.builds(
    lambda name, score, left, top, wide, high: Region(name, score, (left, top, left + wide, top + high)),
    st.sampled_from(SKIN_CLASSES), st.floats(0, 1), coordinate, coordinate, coordinate, coordinate,
)  # fmt: skip


@given(st.lists(regions, max_size=5))
def test_regions_survive_the_message(items):
    header = Header(stamp=Time(sec=5, nanosec=7), frame_id="camera")
    message = DetectionMessages().fill(items, header)
    assert message.header == header
    again = regions_from_detections(message)
    assert [(r.name, r.score) for r in again] == [(r.name, r.score) for r in items]
    for ours, theirs in zip(again, items, strict=True):
        assert ours.box == pytest.approx(theirs.box, abs=1e-9)


def image(encoding="rgb8", padding=0):
    rows = np.arange(4 * (6 + padding), dtype=np.uint8)
    return Image(height=4, width=2, step=6 + padding, encoding=encoding, data=rows.tobytes())


def test_row_padding_is_left_out():
    assert colour_from_image(image(padding=2))[1, 0].tolist() == [8, 9, 10]


def test_bgr_is_turned():
    assert np.array_equal(colour_from_image(image("bgr8")), colour_from_image(image())[..., ::-1])


def test_other_encodings_and_short_data_are_refused():
    with pytest.raises(PictureError, match="encoding '16UC1'"):
        colour_from_image(image("16UC1"))
    short = image()
    short.data = short.data[:-1]
    with pytest.raises(PictureError, match="cut off"):
        colour_from_image(short)


def test_labels_are_numbered_in_the_papers_order():
    info = label_info(Header(), 0.25)
    assert [(c.class_id, c.class_name) for c in info.class_map] == list(enumerate(LABELS))
    assert info.class_map[6].class_name == "Background"
    assert info.threshold == pytest.approx(0.25)
