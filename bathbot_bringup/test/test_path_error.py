import numpy as np
import pytest
from bathbot_bringup.report.path_error import path_error
from bathbot_depthcorr.geometry.rigid import transform_from
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation


def straight(count=101, spacing=0.002):
    """A path along y, z into the skin along +z of the base."""
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, 1, 3] = spacing * np.arange(count)
    return poses


def walk(poses, speed=0.04, rate=50.0, before=0.01):
    length = poses[-1, 1, 3] + 2 * before
    times = np.arange(0.0, length / speed, 1.0 / rate)
    positions = np.zeros((len(times), 3))
    positions[:, 1] = speed * times - before
    return times, positions, positions[:, 1].clip(0.0)


@settings(deadline=None)
@given(across=st.floats(-0.01, 0.01), depth=st.floats(-0.01, 0.01))
def test_a_constant_offset_is_found_at_every_pose(across, depth):
    poses = straight()
    times, positions, along = walk(poses)
    error = path_error(poses, times, positions + np.array([across, 0.0, depth]), along)
    assert error.passed.all()
    assert_allclose(error.across, across, atol=1e-12)
    assert_allclose(error.depth, depth, atol=1e-12)


@settings(deadline=None)
@given(rotation=st.tuples(*[st.floats(-3, 3)] * 3), shift=st.tuples(*[st.floats(-1, 1)] * 3))
def test_the_error_does_not_depend_on_the_frame(rotation, shift):
    poses = straight()
    times, positions, along = walk(poses)
    positions[:, 0] = 0.003 * np.sin(40.0 * positions[:, 1])
    T = transform_from(Rotation.from_rotvec(rotation).as_matrix(), shift)
    moved = path_error(T @ poses, times, positions @ T[:3, :3].T + T[:3, 3], along)
    still = path_error(poses, times, positions, along)
    assert_allclose(moved.across, still.across, atol=1e-9)
    assert_allclose(moved.time, still.time, atol=1e-6)


def test_the_time_of_passing_is_interpolated():
    poses = straight(3)
    error = path_error(poses, [0.0, 1.0], [[0.0, -0.004, 0.0], [0.0, 0.008, 0.0]], [0.0, 0.008])
    assert_allclose(error.time, [1 / 3, 0.5, 2 / 3])
    assert_allclose(error.distance, [0.0, 0.002, 0.004])


def test_a_path_left_early_is_not_passed_at_its_end():
    poses = straight()
    times, positions, along = walk(poses)
    half = len(times) // 2
    error = path_error(poses, times[:half], positions[:half], along[:half])
    assert error.passed[:40].all()
    assert not error.passed[60:].any()


def test_a_neighbouring_scan_line_is_not_mistaken_for_the_own():
    there = straight(51)
    back = there[::-1].copy()
    back[:, 0, 3] = 0.04
    back[:, :2, :2] = -np.eye(2)
    times, positions, along = walk(there)
    error = path_error(np.concatenate([there, back]), times, positions, along)
    assert error.passed[:51].all()
    assert not error.passed[51:].any()


def follow(planned, per_pose=20):
    """A head that goes exactly along planned positions, and how far it has come."""
    places, dense = np.arange(len(planned)), np.linspace(0.0, len(planned) - 1, per_pose * len(planned))
    actual = np.stack([np.interp(dense, places, planned[:, axis, 3]) for axis in range(3)], axis=1)
    steps = np.linalg.norm(np.diff(actual, axis=0), axis=1)
    return 0.002 * np.arange(len(actual)), actual, np.concatenate([[0.0], np.cumsum(steps)])


def test_a_later_line_does_not_stand_in_for_a_pose_passed_at_the_start():
    """The head begins a hair beyond the first pose; the third line runs the same way, 15 mm beside it."""
    there = straight(51)
    back, again = there[::-1].copy(), there.copy()
    back[:, 0, 3], again[:, 0, 3] = 0.04, 0.015
    planned = np.concatenate([there, back, again])
    times, actual, along = follow(planned)
    error = path_error(planned, times[5:], actual[5:], along[5:])
    assert error.passed.mean() > 0.95
    assert np.nanmax(np.abs(error.across)) < 0.001


def test_a_path_that_crosses_itself_is_followed_to_its_end():
    turn = np.linspace(0.0, 4.0 * np.pi, 250)
    loop = np.tile(np.eye(4), (250, 1, 1))
    loop[:, 0, 3], loop[:, 1, 3] = 0.03 * np.cos(turn), 0.03 * np.sin(turn) + 0.004 * turn
    error = path_error(loop, *follow(loop))
    assert error.passed.all()
    assert np.abs(error.across).max() < 0.0005


def test_a_kink_where_segments_meet_spoils_no_other_pose():
    """A replanned segment begins 1 mm beside the old one, a hair further on: the travel turns across."""
    planned = straight(100)
    planned[50:, 0, 3] = 0.001
    planned[50:, 1, 3] -= 0.0019
    error = path_error(planned, *follow(planned))
    assert error.passed.all()
    assert np.abs(error.across).max() < 1e-4


def test_the_pose_on_which_the_head_comes_to_rest_is_passed():
    poses = straight()
    error = path_error(poses, 0.05 * np.arange(101), poses[:, :3, 3], poses[:, 1, 3])
    assert error.passed.all()
    assert_allclose(error.across, 0.0, atol=1e-12)


def test_the_direction_of_travel_is_that_of_the_positions():
    """A head that has not turned yet: its y lies across the travel, and what is across stays across."""
    poses = straight()
    turned = poses.copy()
    turned[:, :3, 0], turned[:, :3, 1] = poses[:, :3, 1], -poses[:, :3, 0]
    times, positions, along = walk(poses)
    error = path_error(turned, times, positions + np.array([0.001, 0.0, 0.0]), along)
    assert error.passed.all()
    assert_allclose(error.across, 0.001, atol=1e-12)


def test_the_way_to_the_first_pose_is_not_an_error_of_the_path():
    """The head comes from the side and begins there."""
    poses = straight()
    way = np.array([[0.006, -0.001, 0.0], [0.004, 0.0005, 0.0], [0.001, 0.0, 0.0], [0.0, 0.0, 0.0]])
    path = np.stack([np.zeros(300), 0.0008 * np.arange(1, 301), np.zeros(300)], axis=1)
    along = np.concatenate([np.zeros(4), path[:, 1]])
    error = path_error(poses, 0.02 * np.arange(304), np.concatenate([way, path]), along)
    assert_allclose(error.across, 0.0, atol=1e-12)


@pytest.mark.parametrize("actual", [np.zeros((0, 3)), np.ones((50, 3))], ids=["nothing recorded", "far away"])
def test_no_actual_path_gives_no_error_numbers(actual):
    error = path_error(straight(5), np.arange(len(actual)), actual, np.zeros(len(actual)))
    assert not error.passed.any()
    assert np.isnan(error.across).all()


def test_no_planned_path():
    assert len(path_error(np.zeros((0, 4, 4)), [0.0, 1.0], np.zeros((2, 3)), [0.0, 0.0]).across) == 0
