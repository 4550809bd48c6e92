"""How often pictures are drawn for training."""

import numpy as np
import pytest
from bathbot_perception.training.data.augment_geometry import Example
from bathbot_perception.training.data.dataset import class_balance
from hypothesis import given
from hypothesis import strategies as st


def example(classes):
    return Example(np.zeros((4, 4, 3), np.uint8), np.zeros((len(classes), 4)), np.array(classes, np.int64))


sets = st.lists(st.lists(st.integers(0, 5), max_size=6), min_size=1, max_size=12).filter(any)


@given(sets)
def test_every_picture_is_drawn_and_the_mean_is_one(labels):
    weights = class_balance([example(classes) for classes in labels])
    assert (weights > 0).all()
    assert weights.mean() == pytest.approx(1.0)


@given(sets, st.integers(0, 5))
def test_a_picture_with_one_box_more_is_drawn_more_often(labels, extra):
    few, more, *_ = class_balance([example(c) for c in (labels[0], [*labels[0], extra], *labels)])
    assert more > few


def test_by_hand():
    """Four faces and one foot: a face weighs 1/2, a foot 1, the picture without any 1/4."""
    weights = class_balance([example([0, 0, 0]), example([0, 5]), example([])])
    assert weights / weights[2] == pytest.approx([1.5 / 0.25, 1.5 / 0.25, 1.0])
