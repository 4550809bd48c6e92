"""The height of breathing skin."""

import numpy as np
import pytest
from bathbot_scrub.path.surface_map import SkinLevel
from hypothesis import given
from hypothesis import strategies as st

TIMES = np.arange(0.0, 12.0, 0.2)


def filled(heights, times=TIMES):
    level = SkinLevel(6.0, 0.004)
    for time, height in zip(times, heights, strict=True):
        level.add(time, height)
    return level.level


@given(amplitude=st.floats(0.0, 0.003), phase=st.floats(0.0, 6.3), rate=st.floats(0.17, 0.3))
def test_regular_breath_is_averaged(amplitude, phase, rate):
    heights = 0.01 + amplitude * np.sin(2.0 * np.pi * rate * TIMES + phase)
    assert filled(heights) == pytest.approx(0.01, abs=0.35 * amplitude + 1e-9)


def test_first_heights_are_taken_as_they_are():
    assert filled([0.0, 0.001], [0.0, 0.2]) == 0.001


@pytest.mark.parametrize("move", [0.003, -0.003, 0.015])
def test_a_sudden_move_is_followed_at_once_and_kept(move):
    heights = np.where(TIMES < 10.0, 0.0, move)
    for stop in range(51, 61):
        assert filled(heights[:stop], TIMES[:stop]) == pytest.approx(move)


def test_slow_lean_is_followed_within_the_spread():
    heights = 0.0035 * TIMES
    assert abs(filled(heights) - heights[-1]) <= 0.004


def test_older_heights_fill_the_past():
    level = SkinLevel(6.0, 0.004)
    level.add(5.0, 0.002)
    for time in np.arange(1.0, 5.0, 0.2):
        level.add(time, 0.002 * np.sin(2.0 * np.pi * 0.25 * time))
    assert abs(level.level) < 0.0005
