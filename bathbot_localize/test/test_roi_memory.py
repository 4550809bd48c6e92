"""The chosen region stays known while the arm hides it, and is forgotten when it is gone."""

import numpy as np
import pytest
from bathbot_localize.regions import SkinRegion
from bathbot_localize.target.roi_memory import RoiMemory, box_overlap, hidden_share

FREE = np.zeros((100, 200), bool)
HIDING = FREE.copy()
HIDING[40:60, 60:110] = True
WHOLE = SkinRegion("Trunk_skin", 0.9, (50.0, 30.0, 120.0, 80.0))
PART = SkinRegion("Trunk_skin", 0.5, (50.0, 30.0, 90.0, 39.0))


def test_a_region_in_the_open_is_followed():
    memory = RoiMemory("Trunk_skin", 1.0)
    moved = WHOLE._replace(box=(55.0, 30.0, 125.0, 80.0))
    assert memory.update(WHOLE, FREE, 0.0) == WHOLE
    assert memory.update(moved, FREE, 0.1) == moved


def test_the_arm_hides_it_and_the_last_free_box_goes_on():
    memory = RoiMemory("Trunk_skin", 1.0)
    memory.update(WHOLE, FREE, 0.0)
    for stamp in np.arange(0.1, 20.0, 0.1):
        assert memory.update(None, HIDING, stamp) == WHOLE


def test_a_part_that_the_arm_leaves_open_does_not_replace_the_whole():
    memory = RoiMemory("Trunk_skin", 1.0)
    memory.update(WHOLE, FREE, 0.0)
    assert memory.update(PART, HIDING, 0.1) == WHOLE
    assert memory.update(WHOLE, HIDING, 0.2) == WHOLE


def test_the_region_is_followed_again_when_the_arm_has_left():
    memory = RoiMemory("Trunk_skin", 1.0)
    memory.update(WHOLE, FREE, 0.0)
    memory.update(None, HIDING, 0.1)
    moved = WHOLE._replace(box=(60.0, 35.0, 130.0, 85.0))
    assert memory.update(moved, FREE, 5.0) == moved


def test_a_region_that_walked_away_is_forgotten_after_a_while():
    memory = RoiMemory("Trunk_skin", 1.0)
    memory.update(WHOLE, FREE, 0.0)
    assert memory.update(None, FREE, 0.5) == WHOLE
    assert memory.update(None, FREE, 1.5) is None
    assert memory.update(None, HIDING, 1.6) is None


def test_a_region_first_seen_behind_the_arm_is_better_than_nothing():
    assert RoiMemory("Trunk_skin", 1.0).update(WHOLE, HIDING, 0.0) == WHOLE


def test_hidden_share_by_hand():
    assert hidden_share((60.0, 40.0, 110.0, 60.0), HIDING) == 1.0
    assert hidden_share(WHOLE.box, HIDING) == pytest.approx(1000 / 3500)
    assert hidden_share((300.0, 0.0, 400.0, 50.0), HIDING) == 0.0


def test_overlap_counts_against_the_smaller_box():
    assert box_overlap(WHOLE.box, PART.box) == 1.0
    assert box_overlap((0, 0, 10, 10), (5, 0, 15, 10)) == pytest.approx(0.5)
    assert box_overlap((0, 0, 10, 10), (20, 0, 30, 10)) == 0.0
    assert box_overlap((0, 0, 0, 0), (0, 0, 10, 10)) == 0.0
