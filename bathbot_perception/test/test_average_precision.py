import numpy as np
import pytest
from bathbot_perception.evaluation.average_precision import (
    PictureResult,
    average_precision,
    match_detections,
    mean_average_precision,
    precision_recall,
)
from bathbot_perception.regions import Region
from hypothesis import given
from hypothesis import strategies as st

HAND, FACE = "Hand_skin", "Face_skin"


def box(index, shift=0.0):
    return (20.0 * index + shift, 0.0, 20.0 * index + 10.0 + shift, 10.0)


def found(name, score, index, shift=0.0):
    return Region(name, score, box(index, shift))


def test_area_by_hand():
    """Right, wrong, right of 4 boxes: precision 1, 1/2, 2/3 at recall 1/4, 1/4, 1/2."""
    truths = [found(HAND, 1.0, i) for i in range(4)]
    detections = [found(HAND, 0.9, 0), found(HAND, 0.8, 7), found(HAND, 0.7, 2)]
    curve = precision_recall([PictureResult(truths, detections)], HAND)
    assert curve.recall.tolist() == pytest.approx([0.25, 0.25, 0.5])
    assert curve.precision.tolist() == pytest.approx([1.0, 0.5, 2.0 / 3.0])
    assert average_precision(curve) == pytest.approx(0.25 * 1.0 + 0.25 * 2.0 / 3.0)


def test_a_box_is_found_only_once():
    truths = np.array([box(0)])
    assert match_detections(truths, np.array([box(0), box(0)]), 0.5).tolist() == [True, False]


def test_a_detection_may_take_its_second_best_box():
    truths = np.array([[0.0, 0.0, 10.0, 10.0], [2.0, 0.0, 12.0, 10.0]])
    detections = np.array([[0.0, 0.0, 10.0, 10.0], [0.5, 0.0, 10.5, 10.0]])
    assert match_detections(truths, detections, 0.5).tolist() == [True, True]


@given(
    st.lists(st.tuples(st.integers(0, 8), st.floats(0, 1), st.floats(0, 12)), max_size=12), st.integers(1, 8)
)
def test_average_precision_is_a_share_and_falls_with_the_threshold(guesses, count):
    truths = [found(HAND, 1.0, i) for i in range(count)]
    result = [PictureResult(truths, [found(HAND, s, i, shift) for i, s, shift in guesses])]
    values = [average_precision(precision_recall(result, HAND, t)) for t in (0.5, 0.75, 0.95)]
    assert all(-1e-12 <= value <= 1.0 + 1e-12 for value in values)
    assert values == sorted(values, reverse=True)


@given(st.lists(st.integers(0, 30), min_size=1, max_size=10, unique=True))
def test_finding_everything_is_perfect(indices):
    truths = [found(HAND, 1.0, i) for i in indices]
    result = [PictureResult(truths, truths), PictureResult([found(FACE, 1.0, 0)], [found(FACE, 0.2, 0)])]
    assert mean_average_precision(result, (HAND, FACE)) == pytest.approx(1.0)


def test_only_the_order_of_scores_matters():
    truths = [found(HAND, 1.0, i) for i in range(3)]
    first = [found(HAND, 0.9, 0), found(HAND, 0.8, 5), found(HAND, 0.7, 1)]
    second = [region._replace(score=region.score**3) for region in first]
    areas = [average_precision(precision_recall([PictureResult(truths, d)], HAND)) for d in (first, second)]
    assert areas[0] == pytest.approx(areas[1])


def test_classes_that_do_not_occur_are_left_out_of_the_mean():
    result = [PictureResult([found(HAND, 1.0, 0)], [found(HAND, 0.9, 0), found(FACE, 0.9, 3)])]
    assert mean_average_precision(result, (HAND, FACE)) == pytest.approx(1.0)
    assert np.isnan(average_precision(precision_recall(result, FACE)))
    assert np.isnan(mean_average_precision([], (HAND,)))


def test_missing_every_box_is_zero():
    result = [PictureResult([found(HAND, 1.0, 0)], [])]
    assert mean_average_precision(result, (HAND,)) == 0.0


@given(
    st.lists(st.tuples(st.integers(0, 8), st.floats(0, 1), st.floats(0, 12)), max_size=12),
    st.sets(st.integers(0, 8), min_size=1),
    st.sets(st.integers(0, 8)),
)
def test_difficult_boxes_never_lower_the_precision(guesses, plain, hard):
    truths, difficult = [found(HAND, 1.0, i) for i in plain], [found(HAND, 1.0, i) for i in hard - plain]
    detections = [found(HAND, s, i, shift) for i, s, shift in guesses]
    without, excused = (
        precision_recall([PictureResult(truths, detections, some)], HAND) for some in ((), difficult)
    )
    assert average_precision(excused) >= average_precision(without) - 1e-12
    assert excused.truths == without.truths
    assert excused.recall.max(initial=0.0) == without.recall.max(initial=0.0)


def test_finding_a_difficult_box_is_neither_right_nor_wrong():
    """Right, excused, wrong, right of 2 boxes: precision 1, 1/2, 2/3 at recall 1/2, 1/2, 1."""
    truths = [found(HAND, 1.0, i) for i in range(2)]
    detections = [found(HAND, s, i) for i, s in ((0, 0.9), (4, 0.8), (7, 0.7), (1, 0.6))]
    difficult = [found(HAND, 1.0, 4), found(FACE, 1.0, 7)]
    curve = precision_recall([PictureResult(truths, detections, difficult)], HAND)
    assert curve.recall.tolist() == pytest.approx([0.5, 0.5, 1.0])
    assert curve.precision.tolist() == pytest.approx([1.0, 0.5, 2.0 / 3.0])
