"""Head poses to joints along a path."""

import numpy as np
import pytest
from arm_poses import ARM, TARGET, TOUCH, facing, straight
from bathbot_depthcorr.geometry.rigid import rotation_angle
from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.tool_path import densify, solve_path
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation


@given(length=st.floats(0.01, 0.2), turn=st.floats(0.0, 0.6))
def test_dense_poses_keep_ends_spacing_and_rigidity(length, turn):
    poses = straight(length, 12, turn)
    lengths, dense = densify(poses)
    assert_allclose(dense[[0, -1]], poses[[0, -1]], atol=1e-9)
    assert np.diff(lengths).max() <= 0.001 + 1e-9
    assert rotation_angle(dense[:-1, :3, :3].swapaxes(1, 2) @ dense[1:, :3, :3]).max() <= 0.0101
    assert lengths[-1] == pytest.approx(length)


def test_equal_poses_make_no_path():
    assert len(densify(np.stack([TARGET, TARGET]))[0]) == 1


@given(length=st.floats(0.02, 0.12), turn=st.floats(-0.4, 0.4))
@settings(max_examples=30)
def test_a_path_stays_on_its_branch_and_on_its_poses(length, turn):
    _, dense = densify(straight(length, 20, turn))
    joints = solve_path(ARM, dense, TOUCH)
    assert_allclose(ARM.head(joints), dense, atol=1e-9)
    assert np.abs(np.diff(joints, axis=0)).max() < 0.08


def test_a_path_out_of_reach_names_its_first_pose():
    poses = np.stack([TARGET, facing((0.9, 0.0, 0.2))])
    with pytest.raises(UnreachableError, match="out of reach") as caught:
        solve_path(ARM, densify(poses)[1], TOUCH)
    assert caught.value.index > 0


def test_a_path_through_the_stretched_wrist_is_refused():
    # joint 5 passes zero while joint 4 stands across: the wrist would have to flip by half a turn
    begin = np.radians([0.0, -60.0, -60.0, 0.0, 8.0, 0.0])
    T = ARM.head(begin)
    aside = T.copy()
    aside[:3, :3] = T[:3, :3] @ Rotation.from_euler("xy", [0.5, -25.0], degrees=True).as_matrix()
    with pytest.raises(UnreachableError):
        solve_path(ARM, densify(np.stack([T, aside]))[1], begin)
