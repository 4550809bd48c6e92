"""Which depth in a box is skin: the nearest layer that fills its middle, not what is before or behind."""

import numpy as np
import pytest
from bathbot_localize.surface.skin_layer import away_from_edges, depth_layers, skin_layer

RNG = np.random.default_rng(1)


def skin(low=0.60, high=0.75):
    return RNG.uniform(low, high, (40, 50))


def test_what_lies_behind_a_gap_is_not_skin_of_the_region():
    depth = skin()
    depth[:, 30:] = RNG.uniform(1.1, 1.4, (40, 20))
    layer = skin_layer(depth)
    assert layer[:, :30].all()
    assert not layer[:, 30:].any()


def test_a_chin_before_the_chest_is_not_the_chest():
    depth = skin()
    depth[:6, 10:40] = RNG.uniform(0.40, 0.45, (6, 30))
    layer = skin_layer(depth)
    assert not layer[:6, 10:40].any()
    assert layer[6:].all()


def test_a_bent_arm_is_found_before_the_wall_in_the_middle_of_its_box():
    depth = np.full((40, 50), 1.3)
    depth[:, :18] = skin()[:, :18]
    depth[30:] = skin()[30:]
    layer = skin_layer(depth)
    assert layer[35, 40]
    assert not layer[5, 40]


def test_without_a_layer_that_fills_the_middle_the_largest_part_counts():
    depth = np.full((40, 50), np.nan)
    depth[:, :3] = 0.5
    depth[:, -12:] = 0.9
    layer = skin_layer(depth)
    assert layer.any()
    assert layer.sum() in (120, 480)


def test_a_few_flying_pixels_before_the_skin_are_no_layer():
    depth = skin()
    depth[0, :9] = 0.30
    layer = skin_layer(depth)
    assert not layer[0, :9].any()
    assert layer[1:].all()


def test_flying_pixels_between_two_surfaces_do_not_join_them():
    depth = skin(0.60, 0.70)
    depth[:, 30:] = 1.2
    depth[:10, 30] = RNG.uniform(0.7, 1.2, 10)
    assert skin_layer(depth)[:, 31:].sum() == 0


def test_a_thigh_that_runs_away_is_one_layer():
    assert skin_layer(np.linspace(0.5, 1.0, 2000).reshape(40, 50)).all()


@pytest.mark.parametrize("depth", [np.full((5, 6), np.nan), np.full((5, 6), 0.7)])
def test_nothing_is_no_layer_and_one_depth_is_one(depth):
    assert (skin_layer(depth) == np.isfinite(depth)).all()
    assert len(depth_layers(depth)) == int(np.isfinite(depth).any())


def test_steps_are_edges_and_slopes_and_holes_are_not():
    depth = np.linspace(0.6, 0.7, 20)[None, :] * np.ones((10, 1))
    depth[3, 4] = np.nan
    assert away_from_edges(depth).all()
    depth[:, 12:] += 0.05
    inside = away_from_edges(depth)
    assert not inside[:, 11:13].any()
    assert inside[:, :11].all()
    assert inside[:, 13:].all()


def test_edges_do_not_depend_on_which_way_the_picture_is_turned():
    depth = skin(0.6, 0.62)
    depth[10:20, 10:20] += 0.1
    np.testing.assert_array_equal(away_from_edges(depth.T), away_from_edges(depth).T)
