"""Where the target's disc is put: the centre if it can be, near it if not, never behind the skin."""

import numpy as np
import pytest
from bathbot_localize.surface.disc import NoSkinError, candidate_discs, disc_share
from hypothesis import given, settings
from hypothesis import strategies as st

U, V = np.arange(100.0, 200.0, 2.0), np.arange(50.0, 130.0, 2.0)  # a grid of 40 x 50
CENTRE = (149.3, 90.2)


def choose(*arguments):
    """The first of the candidates."""
    return next(candidate_discs(*arguments))


def grid():
    return np.meshgrid(U, V)


def test_a_full_region_keeps_its_exact_centre():
    disc = choose(np.ones((40, 50), bool), U, V, CENTRE, 12.0)
    assert disc.pixel == CENTRE
    assert disc.radius_px == 12.0


def test_small_holes_do_not_move_the_target():
    skin = np.random.default_rng(0).random((40, 50)) > 0.2
    assert choose(skin, U, V, CENTRE, 12.0).pixel == CENTRE


def test_a_hole_at_the_centre_makes_the_disc_larger():
    u, v = grid()
    skin = np.hypot(u - CENTRE[0], v - CENTRE[1]) > 8.0
    disc = choose(skin, U, V, CENTRE, 12.0)
    assert disc.pixel == CENTRE
    assert disc.radius_px > 12.0


def test_a_narrow_limb_makes_the_disc_smaller():
    _, v = grid()
    skin = np.abs(v - CENTRE[1]) <= 6.0
    disc = choose(skin, U, V, CENTRE, 12.0)
    assert disc.pixel == CENTRE
    assert disc.radius_px < 12.0


@settings(max_examples=50, deadline=None)
@given(left=st.floats(155.0, 185.0))
def test_an_empty_centre_moves_the_target_to_the_nearest_skin(left):
    u, _ = grid()
    skin = u >= left
    disc = choose(skin, U, V, CENTRE, 12.0)
    assert disc.pixel[0] >= left
    assert disc.pixel[0] <= left + 12.0  # no farther in than the smallest disc needs
    assert abs(disc.pixel[1] - CENTRE[1]) <= 2.0


@pytest.mark.parametrize(
    "skin", [np.zeros((40, 50), bool), np.indices((40, 50)).sum(0) % 7 == 0], ids=["none", "sieve"]
)
def test_a_region_without_a_place_is_refused(skin):
    with pytest.raises(NoSkinError, match="depth"):
        choose(skin, U, V, CENTRE, 12.0)


def test_share_of_a_half_filled_disc_is_a_half():
    skin = np.zeros((41, 41), bool)
    skin[:, 21:] = True
    assert disc_share(skin, 8.0)[20, 20] == pytest.approx(0.5, abs=0.06)


def test_further_candidates_lie_farther_and_farther_from_the_centre():
    discs = list(candidate_discs(np.ones((40, 50), bool), U, V, CENTRE, 12.0))
    away = [np.hypot(*np.subtract(disc.pixel, CENTRE)) for disc in discs]
    assert away[:3] == [0.0, 0.0, 0.0]  # smaller and smaller at the centre first
    assert [disc.radius_px for disc in discs[:3]] == pytest.approx([12.0, 8.4, 6.0])
    assert (np.diff(away) >= 0.0).all()
    assert len({disc.pixel for disc in discs}) == 9
