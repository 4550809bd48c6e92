"""Joint paths, their timing, and the planner of free motions."""

import numpy as np
import pytest
from arm_poses import ARM, HOME, PLANNER, TARGET, TOUCH, facing
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.tool_path import densify, retreated, solve_path
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

reachable = st.tuples(
    st.floats(0.48, 0.56),
    st.floats(-0.12, 0.12),
    st.floats(0.1, 0.3),
    st.floats(-30, 30),
    st.floats(0, 30),
    st.floats(-90, 90),
)


@given(place=reachable)
@settings(max_examples=25, deadline=None)
def test_the_way_to_a_standoff_stays_on_the_arms_side(place):
    target = facing(place[:3], yaw=place[3], pitch=place[4], roll=place[5])
    standoff = retreated(target, 0.06)
    try:
        path = PLANNER.to_pose(HOME, standoff)
    except UnreachableError:
        reject()
    assert_allclose(ARM.head(path.joints[-1]), standoff, atol=1e-6)
    frames = ARM.link_frames(path.joints)
    tips = frames[:, 6, :3, 3] + SCRUB_HEAD.length * frames[:, 6, :3, 2]
    beyond = np.concatenate([tips, frames[:, 4, :3, 3]]) @ target[:3, 2] - target[:3, 3] @ target[:3, 2]
    assert beyond.max() < -0.03  # at least half the stand-off is left


def test_most_places_in_front_of_the_arm_have_a_way():
    rng = np.random.default_rng(0)
    found = 0
    for _ in range(60):
        x, y, z = rng.uniform((0.48, -0.12, 0.1), (0.56, 0.12, 0.3))
        target = facing(
            (x, y, z), yaw=rng.uniform(-30, 30), pitch=rng.uniform(0, 30), roll=rng.uniform(-90, 90)
        )
        try:
            path = PLANNER.to_pose(HOME, retreated(target, 0.06))
            PLANNER.to_home(path.joints[-1])
            found += 1
        except UnreachableError:
            continue
    assert found >= 54


def test_the_way_home_from_a_far_chest_with_the_wrist_wound_up():
    """Where folding the arm with the wrist as it stands would push the head at the person."""
    start = np.radians([53.46, -68.546, -13.697, -68.816, -111.569, 339.287])
    path = PLANNER.to_home(start)
    assert_allclose(path.joints[-1], HOME, atol=1e-9)
    side = retreated(ARM.head(start), -0.03)
    frames = ARM.link_frames(path.joints)
    heads = frames[:, 6, :3, 3] + SCRUB_HEAD.length * frames[:, 6, :3, 2]
    assert (heads @ side[:3, 2]).max() - side[:3, 2] @ side[:3, 3] < 0.021


def test_a_target_out_of_reach_says_where():
    with pytest.raises(UnreachableError, match=r"\(1\.000, 0\.000, 0\.200\) m"):
        PLANNER.to_pose(HOME, facing((1.0, 0.0, 0.2)))


def test_a_line_runs_along_the_heads_axis():
    path = PLANNER.line(TOUCH, -0.1, 0.25)
    heads = ARM.head(path.joints)
    moved = heads[:, :3, 3] - TARGET[:3, 3]
    assert_allclose(np.linalg.norm(np.cross(moved, TARGET[:3, 2]), axis=1), 0.0, atol=1e-9)
    assert moved[-1] @ TARGET[:3, 2] == pytest.approx(-0.1)


def test_a_line_too_long_is_shortened_only_when_allowed():
    with pytest.raises(UnreachableError):
        PLANNER.line(TOUCH, 0.6, 0.1)
    path = PLANNER.line(TOUCH, 0.6, 0.1, shorter=0.02)
    assert 0.02 <= path.end < 0.6


def test_a_line_is_the_tool_path_between_its_ends():
    line, ends = PLANNER.line(TOUCH, -0.0995, 0.25), np.stack([TARGET, retreated(TARGET, 0.0995)])
    path = PLANNER.tool_path(TOUCH, ends, 0.25, 0.002)
    assert_allclose(line.joints, path.joints, atol=1e-9)
    assert_allclose(line.lengths, path.lengths, atol=1e-9)
    assert_allclose(line.speed_limit, path.speed_limit, rtol=1e-6)


@given(asked=st.floats(0.25, 0.9))
@settings(max_examples=20, deadline=None)
def test_a_shortened_line_uses_most_of_what_is_within_reach(asked):
    """The joints' own reach, searched for pose by pose in steps of 5 mm."""
    T, reach = ARM.head(TOUCH), 0.0
    while (
        reach + 0.005 < asked and np.isfinite(ARM.solve_head(retreated(T, -reach - 0.005), ARM.limits)).any()
    ):
        reach += 0.005
    path = PLANNER.line(TOUCH, asked, 0.1, shorter=0.02)
    gone = (ARM.head(path.joints[-1])[:3, 3] - T[:3, 3]) @ T[:3, 2]
    assert 0.85 * reach <= gone <= reach + 0.006


def test_a_far_beginning_is_reached_over_the_skin():
    first = TARGET.copy()
    first[:3, 3] += 0.08 * TARGET[:3, 1]
    poses = PLANNER.lead_in(TARGET, first, 0.03, 0.35)
    height = (poses[:, :3, 3] - TARGET[:3, 3]) @ -TARGET[:3, 2]
    assert_allclose(height, [0.0, 0.03, 0.03, 0.0], atol=1e-12)
    with pytest.raises(UnreachableError, match="approach its start"):
        PLANNER.lead_in(TARGET, first, 0.03, 0.05)


def test_the_way_home_is_the_way_the_arm_came():
    """Scrubbed beside the target, the wrist wound up, retracted: over the skin and back, nowhere else."""
    came = PLANNER.to_pose(HOME, retreated(TARGET, 0.06))
    line = PLANNER.line(came.joints[-1], 0.06, 0.03)
    ends = np.stack([TARGET, TARGET])
    ends[1, :3, 3] += 0.05 * TARGET[:3, 1]
    turns = Rotation.from_euler("z", np.linspace(0.0, -200.0, 60)[:, None], degrees=True).as_matrix()
    poses = np.tile(TARGET, (60, 1, 1))
    poses[:, :3, :3] = TARGET[:3, :3] @ turns
    poses[:, :3, 3] = TARGET[:3, 3] + np.linspace(0.0, 0.05, 60)[:, None] * TARGET[:3, 1]
    scrubbed = solve_path(ARM, densify(poses)[1], line.joints[-1])[-1]
    start = PLANNER.line(scrubbed, -0.10, 0.25).joints[-1]
    path = PLANNER.to_home(start, came)
    assert_allclose(path.joints[-1], HOME, atol=1e-9)
    way = np.array([path.at(s) for s in np.linspace(0.0, path.end, 400)])
    heads, known = ARM.head(way)[:, :3, 3], ARM.head(came.joints)[:, :3, 3]
    over = ARM.head(start)[:3, 3] + np.linspace(0.0, 1.0, 50)[:, None] * (known[-1] - ARM.head(start)[:3, 3])
    allowed = np.concatenate([known, over, known[-1] - np.linspace(0.0, 0.05, 20)[:, None] * TARGET[:3, 2]])
    assert np.linalg.norm(heads[:, None] - allowed, axis=-1).min(axis=1).max() < 0.03
    assert np.abs(np.diff(way, axis=0)).max() < 0.2


def test_a_way_that_did_not_begin_at_home_is_not_taken_back():
    near = PLANNER.to_pose(HOME, retreated(TARGET, 0.06))
    elsewhere = PLANNER.joint_path(near.joints[-1], near.joints[-1] + 0.05)
    assert_allclose(PLANNER.to_home(near.joints[-1], elsewhere).joints[-1], HOME, atol=1e-9)


@pytest.mark.parametrize("behind", [0.02, 0.05])
def test_who_stands_straight_before_its_stand_off_does_not_draw_back_first(behind):
    standoff = retreated(TARGET, 0.06)
    start = PLANNER.line(TOUCH, -(0.06 + behind), 0.25).joints[-1]
    heads = ARM.head(PLANNER.to_pose(start, standoff).joints)
    along = (heads[:, :3, 3] - standoff[:3, 3]) @ standoff[:3, 2]
    assert (np.diff(along) > -1e-6).all()
    assert along[0] == pytest.approx(-behind, abs=1e-6)
    assert_allclose(heads[-1], standoff, atol=1e-6)


def test_an_arm_that_is_at_home_goes_nowhere_to_be_at_home():
    """It drew back by 0.16 m and came again."""
    heads = ARM.head(PLANNER.to_home(HOME).joints)[:, :3, 3]
    assert np.ptp(heads, axis=0).max() < 1e-6
