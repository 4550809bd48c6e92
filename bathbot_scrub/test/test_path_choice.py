"""Which path washes most."""

import numpy as np
import pytest
from bathbot_scrub.errors import SurfaceError
from bathbot_scrub.path.height_field import HeightField
from bathbot_scrub.path.patch import PatchGrid
from bathbot_scrub.path.path_choice import around_target, candidates, choose_patch, washed
from bathbot_scrub.path.scan_lines import Ground
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

SETTINGS = ScrubPlannerSettings()
NOTHING = np.empty((0, 3))  # seen but the field itself
GRID = PatchGrid(np.eye(4), 0.13, 0.12, 0.004)
X, Y = np.meshgrid(GRID.x, GRID.y)


def flat(valid=None):
    return HeightField(GRID, 0.0 * X, np.ones(X.shape, dtype=bool) if valid is None else valid)


def test_patch_has_the_extent_of_the_settings():
    patch = choose_patch(flat(), NOTHING, SETTINGS)
    assert patch.skin.sum() * GRID.cell**2 == pytest.approx(0.14 * 0.12, rel=0.06)
    assert np.abs(X[patch.ground.allowed]).max() <= 0.07 - 0.008
    assert patch.ground.allowed.sum() < patch.skin.sum()


def test_ground_keeps_off_edges_and_holes():
    hole = np.hypot(X - 0.03, Y) < 0.01
    patch = choose_patch(flat(~hole), NOTHING, SETTINGS)
    assert not patch.ground.allowed[np.hypot(X - 0.03, Y) < 0.01 + SETTINGS.edge_margin - GRID.cell].any()


def test_steep_skin_is_left_out():
    limb = np.sqrt(0.05**2 - np.minimum(np.abs(Y), 0.0499) ** 2) - 0.05
    patch = choose_patch(HeightField(GRID, limb, np.abs(Y) < 0.05), NOTHING, SETTINGS)
    assert np.abs(Y[patch.skin]).max() <= 0.05 * np.sin(np.radians(60.0)) + GRID.cell


def test_target_off_the_skin_is_refused():
    with pytest.raises(SurfaceError, match="contact target itself"):
        choose_patch(flat(X > 0.02), NOTHING, SETTINGS)


def test_best_path_washes_nearly_all():
    patch = choose_patch(flat(), NOTHING, SETTINGS)
    best = candidates(flat(), patch, SETTINGS)[0]
    assert best.worth == washed(best.path.plane, patch, 0.025).sum()
    assert best.worth > 0.93 * patch.skin.sum()


def test_a_long_narrow_ground_is_scanned_along_its_length():
    """Only a strip across the target's direction of travel is left: the path runs in it."""
    patch = choose_patch(flat(), NOTHING, SETTINGS)
    strip = patch._replace(ground=Ground(GRID, patch.ground.allowed & (np.abs(X) < 0.006)))
    best = candidates(flat(), strip, SETTINGS)[0]
    assert np.ptp(best.path.plane[:, 1]) > 0.04
    assert np.ptp(best.path.plane[:, 0]) < 0.012


def test_only_the_part_around_the_target_counts():
    mask = np.abs(X) > 0.02
    mask |= np.abs(X) < 0.01
    assert np.array_equal(around_target(mask), np.abs(X) < 0.01)
    assert not around_target(np.abs(X) > 0.02).any()


def wall(y, height):
    """Points of a wall along x at `y`, from the skin up to `height` [m]."""
    x, z = np.meshgrid(np.arange(-0.1, 0.1, 0.004), np.arange(0.0, height, 0.004))
    return np.stack([x, np.full_like(x, y), z], axis=-1)


def test_the_brush_keeps_off_what_rises_beside_the_skin():
    allowed = choose_patch(flat(), wall(0.045, 0.06), SETTINGS).ground.allowed
    assert Y[allowed].max() <= 0.045 - SETTINGS.head_room
    assert Y[allowed].max() > 0.045 - SETTINGS.head_room - 2 * GRID.cell


def test_relief_that_bristles_take_up_and_what_lies_under_the_skin_count_for_nothing():
    free = choose_patch(flat(), NOTHING, SETTINGS).ground.allowed
    for harmless in (wall(0.045, 0.010), -wall(-0.045, 0.06)):
        assert (choose_patch(flat(), harmless, SETTINGS).ground.allowed == free).all()


def test_a_target_without_room_for_the_head_is_refused():
    with pytest.raises(SurfaceError, match="room for the brush"):
        choose_patch(flat(), wall(0.02, 0.06), SETTINGS)
