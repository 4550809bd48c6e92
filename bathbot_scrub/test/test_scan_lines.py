"""Scan lines: spacing on the skin, smooth turns, nothing off the ground."""

import numpy as np
import pytest
from bathbot_scrub.path.height_field import HeightField
from bathbot_scrub.path.patch import PatchGrid
from bathbot_scrub.path.scan_lines import Ground, line_offsets, scan_paths, skin_distance, turn
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

GRID = PatchGrid(np.eye(4), 0.12, 0.12, 0.004)
X, Y = np.meshgrid(GRID.x, GRID.y)


def ground(half_x=0.06, half_y=0.04):
    return Ground(GRID, (np.abs(X) <= half_x) & (np.abs(Y) <= half_y))


def field(height):
    return HeightField(GRID, height, np.ones(X.shape, dtype=bool))


@given(gap=st.floats(0.01, 0.1), spacing=st.floats(0.02, 0.05))
def test_turn_ends_on_the_next_line_heading_back(gap, spacing):
    path = turn(gap, spacing)
    assert_allclose(path[0], 0.0)
    assert_allclose(path[-1], [0.0, gap], atol=1e-3 * gap)
    heading = np.unwrap(np.arctan2(*np.diff(path, axis=0).T[::-1]))
    assert heading[0] == pytest.approx(0.0, abs=0.01)
    assert heading[-1] == pytest.approx(np.pi, abs=0.01)
    assert np.all(np.diff(heading) > -1e-6)


def test_turn_begins_and_ends_without_curvature():
    path = turn(0.035, 0.035)
    steps = np.diff(path, axis=0)
    rate = np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))) / np.linalg.norm(steps, axis=1)[1:]
    assert rate[0] < 2.0
    assert rate[-1] < 2.0
    assert rate.max() < 1.05 * 2.0 * np.pi / np.linalg.norm(steps, axis=1).sum()


def test_lengths_on_the_skin_of_a_cylinder():
    along, across = skin_distance(field(np.sqrt(0.15**2 - Y**2) - 0.15))
    assert_allclose(along, X, atol=1e-12)
    assert_allclose(across, 0.15 * np.arcsin(Y / 0.15), atol=1e-4)


@given(radius=st.floats(0.08, 0.5))
@settings(max_examples=20)
def test_lines_are_evenly_spaced_on_the_skin(radius):
    skin = field(np.sqrt(radius**2 - np.minimum(np.abs(Y), 0.9 * radius) ** 2) - radius)
    offsets = line_offsets(skin, ground(half_y=0.045), 0.07, 0.04)
    spacing = np.diff(radius * np.arcsin(offsets / radius))
    assert len(offsets) == 3
    assert_allclose(spacing, 0.035, atol=2e-4)
    assert offsets[1] == pytest.approx(0.0, abs=1e-4)


def test_narrow_ground_has_one_line():
    assert_allclose(line_offsets(field(0 * X), ground(half_y=0.004), 0.07, 0.04), [0.0], atol=1e-12)


@pytest.mark.parametrize("index", range(4))
def test_path_starts_at_the_target_and_stays_on_the_ground(index):
    path = scan_paths(ground(), [-0.035, 0.0, 0.035], 0.035)[index]
    assert_allclose(path.plane[0], 0.0)
    assert ground().bears(path.plane).all()
    assert path.lines == 3
    assert np.linalg.norm(np.diff(path.plane, axis=0), axis=1).max() < 0.0015
    assert np.sign(path.plane[5, 0]) == (1.0 if index < 2 else -1.0)


@pytest.mark.parametrize("index", range(4))
def test_path_has_no_corners(index):
    steps = np.diff(scan_paths(ground(), [-0.035, 0.0, 0.035], 0.035)[index].plane, axis=0)
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    assert np.abs(np.diff(heading)).max() < np.radians(6.0)


@settings(max_examples=40)
@given(x=st.floats(-0.06, 0.06), y=st.floats(-0.045, 0.045), size=st.floats(0.004, 0.02))
def test_no_path_crosses_a_hole(x, y, size):
    base = ground()
    holed = Ground(GRID, base.allowed & (np.hypot(X - x, Y - y) > size))
    for path in scan_paths(holed, [-0.035, 0.0, 0.035], 0.035):
        assert holed.bears(path.plane[1:]).all()
