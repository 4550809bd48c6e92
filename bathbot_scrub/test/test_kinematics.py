"""Forward and inverse kinematics of the RM65."""

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_scrub.arm.branches import nearest, unwind, wrap
from bathbot_scrub.arm.errors import ArmSettingsError, InvalidPoseError, JointLimitError, UnreachableError
from bathbot_scrub.rm65.arm.inverse_kinematics import (
    all_branches,
    check_poses,
    distance_to_singularity,
    solve_head,
)
from bathbot_scrub.rm65.arm.kinematics import BASE_HEIGHT, FLANGE_OFFSETS, FOREARM, UPPER_ARM
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

ARM = RM65("6F")
JOINTS = np.random.default_rng(1).uniform(RM65_LIMITS.lower, RM65_LIMITS.upper, (3000, 6))
angles = st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6).map(np.array)


@pytest.mark.parametrize("variant", FLANGE_OFFSETS)
def test_upright_arm_is_as_tall_as_its_parts(variant):
    flange = RM65(variant).flange(np.zeros(6))
    height = BASE_HEIGHT + UPPER_ARM + FOREARM + FLANGE_OFFSETS[variant]
    assert_allclose(flange, transform_from(np.diag([-1.0, -1.0, 1.0]), (0.0, 0.0, height)), atol=1e-12)


def test_published_height_of_the_6f():
    assert_allclose(ARM.flange(np.zeros(6))[2, 3], 0.879, atol=5e-4)


def test_unknown_variant_is_refused():
    with pytest.raises(ArmSettingsError, match="known are B, 6F, 6FB"):
        RM65("7F")


def test_link_frames_end_in_the_flange_and_broadcast():
    frames = ARM.link_frames(JOINTS[:6].reshape(2, 3, 6))
    assert frames.shape == (2, 3, 7, 4, 4)
    assert_allclose(frames[..., 6, :, :], ARM.flange(JOINTS[:6]).reshape(2, 3, 4, 4))
    assert_allclose(ARM.head(JOINTS[0]), ARM.flange(JOINTS[0]) @ ARM.tool.T_flange_head)


@given(joints=angles)
def test_jacobian_is_the_derivative_of_the_head_pose(joints):
    step = 1e-6
    here, jacobian = ARM.head(joints), ARM.jacobian(joints)
    for index in range(6):
        moved = ARM.head(joints + step * np.eye(6)[index])
        twist = Rotation.from_matrix(moved[:3, :3] @ here[:3, :3].T).as_rotvec() / step
        assert_allclose(jacobian[:3, index], (moved[:3, 3] - here[:3, 3]) / step, atol=1e-5)
        assert_allclose(jacobian[3:, index], twist, atol=1e-5)


def test_every_branch_reaches_the_pose():
    poses = ARM.flange(JOINTS)
    solutions = all_branches(ARM, poses)
    assert solutions.shape == (len(JOINTS), 8, 6)
    assert np.isfinite(solutions).all()
    assert_allclose(ARM.flange(solutions), np.broadcast_to(poses[:, None], (len(JOINTS), 8, 4, 4)), atol=1e-9)


def test_the_joints_we_came_from_are_among_the_branches():
    solutions = all_branches(ARM, ARM.flange(JOINTS))
    missed = np.abs(wrap(solutions - JOINTS[:, None])).max(-1).min(-1)
    regular = distance_to_singularity(ARM, JOINTS) > 1e-3
    assert regular.mean() > 0.99
    assert missed[regular].max() < 1e-9


@given(joints=angles, singular=st.sampled_from([0.0, 1e-12]))
def test_wrist_singularity_still_reaches_the_pose(joints, singular):
    joints = np.array([*joints[:4], singular, joints[5]])
    pose = ARM.flange(joints)
    solutions = all_branches(ARM, pose)
    assert_allclose(ARM.flange(solutions), np.broadcast_to(pose, (8, 4, 4)), atol=1e-6)


def test_out_of_reach_is_nan_and_says_so():
    far = transform_from(translation=(1.0, 0.0, 0.5))
    assert np.isnan(solve_head(ARM, far)).all()
    with pytest.raises(UnreachableError, match="nearer target"):
        nearest(solve_head(ARM, far), np.zeros(6), RM65_LIMITS)


@given(joints=angles)
def test_nearest_finds_the_seed(joints):
    joints = np.clip(joints, RM65_LIMITS.lower + 0.01, RM65_LIMITS.upper - 0.01)
    found = nearest(solve_head(ARM, ARM.head(joints)), joints, RM65_LIMITS)
    assert_allclose(ARM.head(found), ARM.head(joints), atol=1e-7)
    if distance_to_singularity(ARM, joints) > 1e-2:
        assert_allclose(found, joints, atol=1e-6)


@given(values=angles, seed=angles)
def test_unwinding_changes_only_whole_turns(values, seed):
    near = unwind(values, 3.0 * seed, RM65_LIMITS)
    turns = (near - values) / (2 * np.pi)
    assert_allclose(turns, np.round(turns), atol=1e-9)


def test_solutions_outside_the_limits_are_left_out():
    solutions = solve_head(ARM, ARM.head(JOINTS))
    inside = solutions[np.isfinite(solutions).all(-1)]
    assert RM65_LIMITS.contain(inside).all()
    assert 4 < np.isfinite(solutions).all(-1).sum(-1).mean() < 8


@pytest.mark.parametrize(
    "spoil",
    [
        pytest.param(lambda T: T * np.nan, id="not finite"),
        pytest.param(lambda T: np.diag([2.0, 1.0, 1.0, 1.0]) @ T, id="stretched"),
        pytest.param(lambda T: np.diag([-1.0, 1.0, 1.0, 1.0]) @ T, id="mirrored"),
        pytest.param(lambda T: T[:3], id="shape"),
    ],
)
def test_poses_that_are_none_are_refused(spoil):
    with pytest.raises(InvalidPoseError):
        check_poses(spoil(ARM.flange(JOINTS[0])))


def test_limit_error_names_joint_value_and_limit():
    with pytest.raises(JointLimitError, match="joint 2") as caught:
        RM65_LIMITS.check(np.radians([0.0, 131.0, 0.0, 0.0, 0.0, 0.0]))
    assert caught.value.limit == pytest.approx(np.radians(130.0))


@given(values=angles, joint=st.integers(0, 5))
def test_a_step_is_refused_exactly_when_a_joint_would_be_too_fast(values, joint):
    step = 0.01 * RM65_LIMITS.speed
    RM65_LIMITS.check_step(values, values + step, 0.01)
    step[joint] *= 1.1
    with pytest.raises(JointLimitError, match=f"joint {joint + 1}"):
        RM65_LIMITS.check_step(values, values + step, 0.01)


def test_a_step_to_nowhere_is_refused():
    with pytest.raises(JointLimitError):
        RM65_LIMITS.check_step(np.zeros(6), np.full(6, np.nan), 0.01)
