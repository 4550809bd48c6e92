"""The patch of skin around a target."""

import numpy as np
import pytest
from bathbot_scrub.errors import SurfaceError
from bathbot_scrub.path.patch import PatchGrid, around, connected_skin, patch_frame
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from synthetic_skin import DISTANCE, plane, somewhere, target


def grid(T_base_target=None):
    return PatchGrid(patch_frame(target() if T_base_target is None else T_base_target), 0.08, 0.06, 0.004)


def in_patch(surface):
    return grid().to_patch(surface)


def test_patch_frame_points_out_of_the_skin():
    frame = patch_frame(target(travel=(0, 0, 1)))
    assert_allclose(frame[:3, 2], [-1, 0, 0])
    assert_allclose(frame[:3, 0], [0, 0, 1])
    assert np.linalg.det(frame[:3, :3]) == pytest.approx(1.0)


@given(seed=st.integers(0, 200))
def test_points_go_to_the_patch_and_back(seed):
    cells = grid(somewhere(seed))
    points = np.random.default_rng(seed).normal(size=(5, 3))
    assert_allclose(cells.to_base(cells.to_patch(points)), points, atol=1e-12)


@given(seed=st.integers(0, 200))
def test_binning_keeps_count_and_mean(seed):
    points = np.random.default_rng(seed).uniform(-0.05, 0.05, size=(300, 3))
    cells = grid().bin(points)
    assert cells.count.sum() == 300
    assert np.nansum(cells.height * cells.count) == pytest.approx(points[:, 2].sum())


def test_binning_puts_the_target_in_the_middle():
    cells = grid().bin([[0.0, 0.0, 0.01], [0.004, 0.0, 0.02], [0.0, -0.004, 0.03], [1.0, 0.0, 0.0]])
    row, column = len(grid().y) // 2, len(grid().x) // 2
    assert_allclose(cells.height[row, column : column + 2], [0.01, 0.02])
    assert cells.height[row - 1, column] == pytest.approx(0.03)
    assert cells.count.sum() == 3


def test_skin_ends_at_a_step_in_depth():
    """A hand 30 mm before the wall is not skin of the wall's patch."""
    surface = plane()
    surface[60:100, 140:180, 0] -= 0.03
    skin = connected_skin(in_patch(surface), 0.012, 0.015)
    assert not skin[62:98, 142:178].any()
    assert skin[30, 30]


def test_skin_ends_at_unknown_pixels():
    surface = plane()
    surface[:, 150:155] = np.nan
    skin = connected_skin(in_patch(surface), 0.012, 0.015)
    assert not skin[:, 150:].any()
    assert skin[:, :149].all()


def test_target_off_the_skin_is_refused():
    surface = plane()
    surface[40:120, 60:160] = np.nan
    with pytest.raises(SurfaceError, match="no skin within 15 mm"):
        connected_skin(in_patch(surface), 0.012, 0.015)


def test_nothing_near_the_target_is_refused():
    with pytest.raises(SurfaceError, match="none of"):
        around(in_patch(plane(out=-1.0)), 0.1, 0.1)


def test_box_holds_all_near_points():
    points = in_patch(plane())
    box = around(points, 0.05, 0.1)
    near = np.all(np.abs(points) < (0.05, 0.05, 0.1), axis=-1)
    assert box.crop(near).sum() == near.sum() > 0
    assert box.crop(points).shape[0] * 0.7 / 300.0 == pytest.approx(0.1, abs=0.01)
    assert pytest.approx(0.7) == DISTANCE
