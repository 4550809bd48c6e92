"""Every branch of the inverse kinematics reaches the pose, near singularities too, and paths keep to one."""

import numpy as np
import pytest
from arm_poses import ARM
from bathbot_scrub.arm.branches import wrap
from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.tool_path import solve_path
from bathbot_scrub.rm65.arm.branch_kernel import fill_branches
from bathbot_scrub.rm65.arm.inverse_kinematics import (
    all_branches,
    distance_to_singularity,
    solve_head,
    why_unreachable,
)
from bathbot_scrub.rm65.arm.kinematics import FLANGE_OFFSETS, FOREARM, UPPER_ARM
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

NEAR = np.sin(np.radians(0.1))  # distance to a singularity below which less is asked for
MANY = 100_000


def round_trip(arm, joints):
    """Largest error of the pose, [m] and of the rotation's entries, over all branches of each of (N, 6)."""
    poses = arm.flange(joints)
    found = all_branches(arm, poses)
    assert np.isfinite(found).all()
    return np.abs(arm.flange(found) - poses[:, None]).max(axis=(1, 2, 3))


def test_all_branches_of_many_random_postures_reach_the_pose():
    rng = np.random.default_rng(7)
    for _ in range(MANY // 5000):
        joints = rng.uniform(RM65_LIMITS.lower, RM65_LIMITS.upper, (5000, 6))
        error = round_trip(ARM, joints)
        far = distance_to_singularity(ARM, joints) > NEAR
        assert error[far].max() < 1e-9
        assert error.max() < 1e-6


@pytest.mark.parametrize("variant", FLANGE_OFFSETS)
@pytest.mark.parametrize("joint", [2, 4], ids=["elbow", "wrist"])
def test_near_a_singularity_the_pose_is_still_met(variant, joint):
    rng = np.random.default_rng(joint)
    joints = rng.uniform(RM65_LIMITS.lower, RM65_LIMITS.upper, (2000, 6))
    joints[:, joint] = rng.uniform(-0.1, 0.1, 2000) * np.pi / 180 * 10.0 ** rng.uniform(-9, 0, 2000)
    assert round_trip(RM65(variant), joints).max() < 1e-6


def test_a_solution_and_the_reason_of_none_share_one_compiled_kernel():
    """Else the first reason would be compiled in the control loop, while the arm leaves the skin."""
    far = ARM.head(ARM.home)
    far[0, 3] += 3.0
    ARM.solve_head(far)
    assert ARM.why_unreachable(far, RM65_LIMITS)
    assert len({signature[5:7] for signature in fill_branches.signatures}) == 1  # lower and upper limits


def test_over_the_shoulder_the_pose_is_still_met():
    rng = np.random.default_rng(3)
    joints = rng.uniform(RM65_LIMITS.lower, RM65_LIMITS.upper, (2000, 6))
    joints[:, 1] = over_the_shoulder(joints[:, 2]) + rng.uniform(-1e-4, 1e-4, 2000)
    assert distance_to_singularity(ARM, joints).max() < 1e-2
    assert round_trip(ARM, joints).max() < 1e-6


def test_limits_only_take_solutions_away():
    joints = np.random.default_rng(5).uniform(RM65_LIMITS.lower, RM65_LIMITS.upper, (3000, 6))
    free, limited = all_branches(ARM, ARM.flange(joints)), solve_head(ARM, ARM.head(joints))
    kept = np.isfinite(limited).all(-1)
    assert_allclose(wrap(limited[kept] - free[kept]), 0.0, atol=1e-9)
    assert (kept == RM65_LIMITS.contain(free)).mean() > 0.9999  # rounding at the limit itself


def over_the_shoulder(q3):
    """q2 that puts the wrist's centre above the shoulder."""
    return -np.arctan2(FOREARM * np.sin(q3), UPPER_ARM + FOREARM * np.cos(q3))


joint_speeds = st.lists(st.floats(-0.4, 0.4), min_size=6, max_size=6).map(np.array)


@given(speeds=joint_speeds, q3=st.floats(0.4, 2.0), q5=st.floats(0.4, 1.8), front=st.sampled_from([-1, 1]))
@settings(max_examples=40, deadline=None)
def test_a_path_keeps_the_branch_it_begins_on(speeds, q3, q5, front):
    """A motion off singularities is found again from its poses alone, wherever it begins."""
    begin = np.array([0.2, 0.0, q3, 0.3, q5, 0.5])
    begin[1] = over_the_shoulder(q3) + front * 0.9
    joints = begin + np.linspace(0.0, 1.0, 200)[:, None] * speeds
    assume(distance_to_singularity(ARM, joints).min() > 0.05 and RM65_LIMITS.contain(joints).all())
    assert_allclose(solve_path(ARM, ARM.head(joints), begin), joints, atol=1e-7)


@pytest.mark.parametrize("off", [0.0, 0.013])
@pytest.mark.parametrize(
    ("begin", "turn", "joint"),
    [
        pytest.param([0.1, -1.0, -1.0, 0.4, 0.3, 0.2], [0.0, 0.0, 0.0, 0.0, -0.6, 0.0], 4, id="wrist"),
        pytest.param([0.1, -0.3, 0.0, 0.4, 1.0, 0.2], [0.0, 0.6, 0.0, 0.0, 0.0, 0.0], 1, id="shoulder"),
    ],
)
def test_a_path_through_a_singularity_is_refused(begin, turn, joint, off):
    """Its poses can be met with another branch behind it, but not on the one it began on."""
    begin = np.array(begin)
    if joint == 1:
        begin[2] = -1.2
        begin[1] += over_the_shoulder(-1.2)
    joints = begin + np.linspace(0.0, 1.0, 200)[:, None] * turn + off * np.eye(6)[joint]
    with pytest.raises(UnreachableError, match=r"singular|beyond its limits|out of reach") as caught:
        solve_path(ARM, ARM.head(joints), joints[0])
    assert 70 < caught.value.index < 130


def test_what_is_too_far_or_too_near_names_the_length():
    far = np.eye(4)
    far[:3, 3] = (1.2, 0.0, 0.3)
    assert "m from the shoulder, more than 0.466 m" in why_unreachable(ARM, far)
    near = np.eye(4)
    near[:3, 3] = (0.0, 0.0, 0.2405 + 0.2725)
    assert "less than 0.046 m" in why_unreachable(ARM, near)


@given(excess=st.floats(0.02, 0.08), side=st.sampled_from([-1.0, 1.0]))
def test_a_joint_beyond_its_limit_is_named_with_the_limit(excess, side):
    joints = np.array([0.3, -0.5, side * (RM65_LIMITS.upper[2] + excess), 0.2, 0.9, 0.1])
    why = why_unreachable(ARM, ARM.head(joints))
    assert "deg, its limit is" in why
    assert why_unreachable(ARM, ARM.head(0.9 * joints)) == ""


def test_a_path_over_a_limit_names_the_joint():
    begin = np.array([2.9, -0.9, -1.2, 0.3, 0.9, 0.5])
    joints = begin + np.linspace(0.0, 0.4, 100)[:, None] * np.eye(6)[0]
    with pytest.raises(UnreachableError, match=r"joint 1") as caught:
        solve_path(ARM, ARM.head(joints), begin)
    assert caught.value.index > 20
