import numpy as np
import pytest
from bathbot_perception.regions import Region, area, overlap
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

side = st.floats(1, 100)
boxes = st.tuples(side, side, side, side).map(lambda b: np.array([b[0], b[1], b[0] + b[2], b[1] + b[3]]))


@given(boxes, boxes)
def test_overlap_is_symmetric_and_a_share(first, second):
    value = overlap(first, second)[0, 0]
    assert 0.0 <= value <= 1.0
    assert_allclose(value, overlap(second, first)[0, 0])


@given(boxes)
def test_a_box_overlaps_itself_wholly(box):
    assert_allclose(overlap(box, box), 1.0)


@given(boxes, boxes, st.floats(0.1, 10), st.floats(-50, 50))
def test_overlap_ignores_scale_and_place(first, second, scale, shift):
    assert_allclose(overlap(first * scale + shift, second * scale + shift), overlap(first, second), atol=1e-6)


@given(boxes, boxes)
def test_boxes_apart_do_not_overlap(first, second):
    assert overlap(first, second + (first[2] + 1.0))[0, 0] == 0.0


def test_half_a_box_overlaps_by_a_half():
    assert overlap(np.array([0, 0, 2, 2]), np.array([0, 0, 1, 2]))[0, 0] == pytest.approx(0.5)


def test_empty_boxes_overlap_nothing():
    empty = np.zeros(4)
    assert overlap(empty, empty)[0, 0] == 0.0
    assert area(np.array([3.0, 3.0, 1.0, 1.0])) == 0.0


def test_a_region_knows_its_middle_and_size():
    region = Region("Hand_skin", 0.5, (10.0, 20.0, 40.0, 80.0))
    assert region.centre == (25.0, 50.0)
    assert region.size == (30.0, 60.0)
