"""The skin while the arm hides it."""

import numpy as np
import pytest
from bathbot_scrub.errors import SurfaceError, TargetLostError
from bathbot_scrub.path.patch import PatchGrid, patch_frame
from bathbot_scrub.path.surface_map import SurfaceMap
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_skin import cylinder, moved, plane, somewhere, target

SETTINGS = ScrubPlannerSettings()


def grid(T_base_target=None):
    return PatchGrid(patch_frame(target() if T_base_target is None else T_base_target), 0.13, 0.12, 0.004)


def hidden(surface):
    """The surface with the middle hidden by an arm."""
    surface = surface.copy()
    surface[50:, 80:140] = np.nan
    return surface


def inside(_):
    return np.s_[15:-15, 15:-15]


@settings(max_examples=15)
@given(out=st.floats(-0.018, 0.018))
def test_hidden_skin_moves_with_the_skin_in_sight(out):
    skin = SurfaceMap(grid(), plane(), 0.0, SETTINGS)
    skin.see(hidden(plane(out=out)), 0.1)
    assert skin.shift == pytest.approx(out, abs=1e-6)
    assert np.abs(skin.field().height[inside(skin)] - out).max() < 1e-4


def test_breathing_cylinder_is_followed_under_noise():
    """A widening limb moves more along the target's normal where it is steep; the median is near."""
    skin = SurfaceMap(grid(), cylinder(noise=0.001), 0.0, SETTINGS)
    for index, out in enumerate(0.003 * np.sin(np.arange(1, 20))):
        skin.see(hidden(cylinder(out=out, noise=0.001, seed=index)), 0.1 * index)
        assert skin.shift == pytest.approx(out, abs=0.0003 + 0.35 * abs(out))


def test_motion_is_told_in_any_frame():
    move = somewhere(3)
    skin = SurfaceMap(grid(move @ target()), moved(move, plane()), 0.0, SETTINGS)
    skin.see(moved(move, plane(out=0.004)), 0.1)
    assert skin.shift == pytest.approx(0.004, abs=1e-6)


def test_what_is_left_of_the_arm_does_not_count():
    """A fifth of the pixels in sight belongs to the arm, 30 mm before the skin."""
    skin = SurfaceMap(grid(), plane(), 0.0, SETTINGS)
    seen = hidden(plane(out=0.003))
    seen[:30, :100, 0] -= 0.03
    skin.see(seen, 0.1)
    assert skin.shift == pytest.approx(0.003, abs=2e-4)
    assert np.abs(skin.field().height[inside(skin)] - 0.003).max() < 5e-4


def test_pictures_are_averaged():
    skin = SurfaceMap(grid(), plane(noise=0.001), 0.0, SETTINGS)
    before = np.std(skin.field().height[inside(skin)])
    for index in range(6):
        skin.see(plane(noise=0.001, seed=10 + index), 0.1 * index)
    assert np.std(skin.field().height[inside(skin)]) < 0.7 * before


def test_too_large_a_shift_loses_the_target():
    skin = SurfaceMap(grid(), plane(), 0.0, SETTINGS)
    skin.see(plane(out=0.012), 0.1)
    with pytest.raises(TargetLostError, match=r"moved \+24 mm"):
        skin.see(plane(out=0.024), 0.2)


@pytest.mark.parametrize(
    "surface", [np.full((160, 220, 3), np.nan), plane(out=0.2)], ids=["all hidden", "gone"]
)
def test_skin_out_of_sight_is_lost_after_a_while(surface):
    skin = SurfaceMap(grid(), plane(), 10.0, SETTINGS)
    assert skin.see(surface, 11.0).cells == 0
    skin.demand_in_sight(10.0 + SETTINGS.lost_after - 0.1)
    with pytest.raises(TargetLostError, match=r"was seen for 3\.5 s"):
        skin.demand_in_sight(13.5)


def test_the_time_of_the_approach_does_not_lose_the_target():
    skin = SurfaceMap(grid(), plane(), 10.0, SETTINGS)
    skin.watch_from(20.0)
    skin.demand_in_sight(20.0 + SETTINGS.lost_after - 0.1)
    with pytest.raises(TargetLostError):
        skin.demand_in_sight(20.0 + SETTINGS.lost_after + 0.1)


def test_a_surface_that_comes_late_takes_no_time_away():
    """On a busy machine the first surfaces of a job were pictured before it began."""
    skin = SurfaceMap(grid(), plane(), 10.0, SETTINGS)
    skin.watch_from(20.0)
    assert skin.see(plane(out=0.001), 18.5).cells > 0
    skin.demand_in_sight(20.0 + SETTINGS.lost_after - 0.1)


def test_a_recalled_surface_counts_as_seen():
    skin = SurfaceMap(grid(), plane(), 10.0, SETTINGS)
    skin.recall(plane(out=0.001), 20.0)
    skin.demand_in_sight(20.0 + SETTINGS.lost_after - 0.1)
    with pytest.raises(TargetLostError):
        skin.demand_in_sight(20.0 + SETTINGS.lost_after + 0.1)


def test_no_skin_at_the_target_is_refused():
    with pytest.raises(SurfaceError):
        SurfaceMap(grid(), np.full((160, 220, 3), np.nan), 0.0, SETTINGS)


def test_surfaces_from_before_tell_the_mean_at_once():
    """The map starts at the end of a breath in, 2 mm too high; the breaths before put that right."""
    skin = SurfaceMap(grid(), plane(out=0.002), 9.0, SETTINGS)
    for time in np.arange(1.0, 9.0, 0.2):
        skin.recall(plane(out=0.002 * np.sin(2.0 * np.pi * 0.25 * time)), time)
    assert skin.shift == 0.0
    assert skin.level == pytest.approx(-0.002, abs=0.0006)
    assert np.abs(skin.field().height[inside(skin)] - 0.002 - skin.level).max() < 1e-4
