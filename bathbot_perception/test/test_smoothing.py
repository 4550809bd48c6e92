"""Smoothing never invents a box."""

import numpy as np
from bathbot_perception.detection.smoothing import Smoothing
from bathbot_perception.regions import Region
from hypothesis import given
from hypothesis import strategies as st

corner, side = st.floats(0.0, 100.0), st.floats(1.0, 60.0)
pictures = st.lists(
    st.lists(
        st.builds(
            lambda name, left, top, width, height: Region(name, 0.5, (left, top, left + width, top + height)),
            st.sampled_from(("Hand_skin", "Face_skin")), corner, corner, side, side,
        ),
        max_size=4,
    ),
    max_size=6,
)  # fmt: skip


@given(pictures=pictures, share=st.floats(0.0, 0.95))
def test_regions_stay_what_they_are_and_no_box_appears_or_goes(pictures, share):
    smoothing = Smoothing(share)
    for regions in pictures:
        shown = smoothing.update(regions)
        assert [(r.name, r.score) for r in shown] == [(r.name, r.score) for r in regions]
        assert all(r.box[2] > r.box[0] and r.box[3] > r.box[1] for r in shown)


def test_a_shaking_box_shakes_less_and_a_jump_is_followed_at_once():
    smoothing, random, shown = Smoothing(0.8), np.random.default_rng(3), []
    boxes = np.array([50.0, 50.0, 90.0, 120.0]) + random.normal(0.0, 2.0, (60, 4))
    for box in boxes:
        shown.append(smoothing.update([Region("Hand_skin", 0.9, tuple(box))])[0].box)
    assert np.std(shown[10:], axis=0).max() < 0.6 * np.std(boxes[10:], axis=0).min()
    jump = Region("Hand_skin", 0.9, (200.0, 10.0, 240.0, 80.0))
    assert smoothing.update([jump]) == [jump]


def test_without_smoothing_boxes_are_as_found():
    smoothing, region = Smoothing(0.0), Region("Hand_skin", 0.9, (1.0, 2.0, 30.0, 40.0))
    smoothing.update([region._replace(box=(2.0, 2.0, 32.0, 40.0))])
    assert smoothing.update([region]) == [region]
