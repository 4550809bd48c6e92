import numpy as np
from bathbot_perception.detection.nms import suppress
from bathbot_perception.regions import overlap
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp


@st.composite
def candidates(draw):
    count = draw(st.integers(0, 25))
    corner = draw(hnp.arrays(float, (count, 2), elements=st.floats(0, 60, width=16)))
    extent = draw(hnp.arrays(float, (count, 2), elements=st.floats(1, 50, width=16)))
    scores = draw(hnp.arrays(float, count, elements=st.floats(0, 1, width=16)))
    classes = draw(hnp.arrays(np.int64, count, elements=st.integers(0, 2)))
    return np.concatenate([corner, corner + extent], axis=1), scores, classes


def clear_of(boxes, limit):
    """Skip cases that rounding decides: the library's overlaps are float32."""
    assume(np.all(np.abs(overlap(boxes, boxes) - limit) > 1e-5))


def brute_force(boxes, scores, classes, limit):
    """Walk all boxes by falling score; keep one unless a kept one of its class covers it."""
    kept = []
    for index in sorted(range(len(boxes)), key=lambda i: (-scores[i], i)):
        rivals = [k for k in kept if classes[k] == classes[index]]
        if all(overlap(boxes[k], boxes[index])[0, 0] <= limit for k in rivals):
            kept.append(index)
    return kept


@given(candidates(), st.floats(0, 1))
def test_suppression_keeps_what_brute_force_keeps(case, limit):
    clear_of(case[0], limit)
    kept = suppress(*case, limit)
    assert set(kept.tolist()) == set(brute_force(*case, limit))


@given(candidates(), st.floats(0, 1))
def test_kept_boxes_come_by_falling_score(case, limit):
    scores = case[1][suppress(*case, limit)]
    assert np.all(np.diff(scores) <= 0)


@given(candidates(), st.floats(0, 1))
def test_suppressing_twice_changes_nothing(case, limit):
    clear_of(case[0], limit)
    kept = suppress(*case, limit)
    again = suppress(*(part[kept] for part in case), limit)
    assert again.tolist() == list(range(len(kept)))


def test_classes_do_not_suppress_each_other():
    boxes = np.array([[0, 0, 10, 10], [0, 0, 10, 10], [1, 0, 11, 10]], dtype=float)
    kept = suppress(boxes, np.array([0.9, 0.8, 0.7]), np.array([0, 1, 0]), 0.5)
    assert kept.tolist() == [0, 1]
