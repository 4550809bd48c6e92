"""Disturbed pictures: what a strength means, and that nothing else changes."""

import numpy as np
import pytest
from bathbot_perception.evaluation import effects
from bathbot_perception.evaluation.conditions import CONDITIONS, STRENGTHS, disturbed
from hypothesis import given
from hypothesis import strategies as st

PICTURE = np.random.default_rng(1).integers(30, 220, (240, 320, 3), dtype=np.uint8)
BOXES = np.array([[10.0, 20.0, 70.0, 80.0], [80.0, 5.0, 120.0, 45.0]])


@pytest.mark.parametrize("strength", STRENGTHS)
@pytest.mark.parametrize("name", CONDITIONS)
def test_a_disturbed_picture_keeps_its_form_and_is_the_same_every_time(name, strength):
    before = PICTURE.copy()
    first, again = (disturbed(PICTURE, BOXES, name, strength, "a.jpg") for _ in range(2))
    assert (first.shape, first.dtype) == (PICTURE.shape, np.uint8)
    assert (first == again).all()
    assert (before == PICTURE).all()
    assert (first != PICTURE).any()


@pytest.mark.parametrize("name", CONDITIONS)
def test_more_strength_changes_more(name):
    changes = [
        np.abs(disturbed(PICTURE, BOXES, name, strength, "a.jpg").astype(int) - PICTURE).mean()
        for strength in STRENGTHS
    ]
    assert changes == sorted(changes)


@given(share=st.floats(0.05, 0.6), seed=st.integers(0, 999))
def test_occlusion_hides_the_stated_share_of_every_region_and_nothing_else(share, seed):
    picture = np.random.default_rng(seed).integers(0, 256, (200, 240, 3), dtype=np.uint8)
    boxes = np.array([[10.0, 20.0, 110.0, 120.0], [130.0, 30.0, 230.0, 190.0]])
    changed = (effects.covered(picture, boxes, share, np.random.default_rng(seed)) != picture).any(axis=2)
    for left, top, right, bottom in boxes.astype(int):
        assert changed[top:bottom, left:right].mean() == pytest.approx(share, abs=0.03)
        changed[top:bottom, left:right] = False
    assert not changed.any()


@given(density=st.floats(0.0, 0.8), value=st.integers(0, 255))
def test_even_steam_is_a_mean_of_picture_and_grey(density, value):
    flat = np.full((40, 40, 3), value, np.uint8)
    seen = effects.veil(flat, density, 0.0, 200.0, np.random.default_rng(0))
    assert np.abs(seen - ((1 - density) * value + density * 200.0)).max() <= 1.0


def test_exposure_scales_the_light_not_the_values():
    grey = np.full((8, 8, 3), 128, np.uint8)
    half = effects.exposed(grey, 0.5, 0.0, np.random.default_rng(0))
    assert half.mean() == pytest.approx(128 * 0.5 ** (1 / 2.2), abs=1.0)
    assert (effects.exposed(grey, 10.0, 0.0, np.random.default_rng(0)) == 255).all()
