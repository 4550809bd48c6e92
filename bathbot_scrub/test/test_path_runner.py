"""Joint paths in time."""

import numpy as np
import pytest
from arm_poses import ARM, HOME, JOINT_PACE, PERIOD, PLANNER, TOUCH, joints_at, run, straight
from bathbot_scrub.arm.errors import JointLimitError
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.paths.joint_path import joint_move, timed_path, timed_tool_path
from bathbot_scrub.rm65.paths.motion_planner import LINE_DECELERATION, line_pace
from bathbot_scrub.rm65.paths.path_runner import PathRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

CORNER = np.array([1.0, 0.0, 0.5, 0.5, 0.5, 0.5])  # behind a half of all joints


@given(goal=st.lists(st.floats(-1.2, 1.2), min_size=6, max_size=6))
@settings(max_examples=30)
def test_joint_moves_respect_speed_acceleration_and_jerk(goal):
    goal = HOME + 0.5 * np.array(goal)
    goal = np.clip(goal, RM65_LIMITS.lower, RM65_LIMITS.upper)
    joints = run(PathRunner(PLANNER.joint_path(HOME, goal), JOINT_PACE, PERIOD))
    assert_allclose(joints[-1], goal, atol=1e-6)
    assert np.abs(np.diff(joints, axis=0)).max(initial=0.0) <= 1.001 * JOINT_PACE.speed * PERIOD
    assert np.abs(np.diff(joints, 2, axis=0)).max(initial=0.0) <= 1.01 * JOINT_PACE.acceleration * PERIOD**2
    assert np.abs(np.diff(joints, 3, axis=0)).max(initial=0.0) <= 1.05 * JOINT_PACE.jerk * PERIOD**3


def test_a_way_on_the_border_of_two_profiles_is_run_too():
    """2 a^3 / j^2: the acceleration is just reached; Ruckig alone finds no motion there."""
    lengths = np.array([0.0, 0.04000000000000004])
    path = timed_path(lengths, np.outer(lengths, np.ones(6)), 2.0, RM65_LIMITS, 1.0)
    assert_allclose(run(PathRunner(path, JOINT_PACE, PERIOD))[-1], path.joints[-1], atol=1e-6)


def test_a_joint_move_beyond_the_limits_is_refused():
    with pytest.raises(JointLimitError, match="joint 3"):
        joint_move(HOME, np.radians([0.0, 0.0, 140.0, 0.0, 0.0, 0.0]), limits=RM65_LIMITS)


def test_a_corner_is_passed_slowly():
    lengths, joints = joint_move(np.zeros(6), np.full(6, 0.5), CORNER, limits=RM65_LIMITS)
    path = timed_path(lengths, joints, 2.0, RM65_LIMITS, 1.0)
    assert path.speed_at(0.5) < 0.3 * path.speed_at(0.05)


def test_speed_limit_leaves_room_to_brake():
    lengths, joints = joint_move(np.zeros(6), np.full(6, 0.5), CORNER, limits=RM65_LIMITS)
    path = timed_path(lengths, joints, 2.0, RM65_LIMITS, 1.0)
    squared = path.speed_limit**2
    assert (np.diff(squared) / np.diff(lengths)).min() >= -2 * 2.0 - 1e-6


def test_scrub_speed_is_kept_and_slows_where_a_joint_demands():
    gentle = PLANNER.tool_path(joints_at(straight(0.1)[0]), straight(0.1), 0.04)
    speeds = np.linalg.norm(
        np.diff(ARM.head(run(PathRunner(gentle, line_pace(0.1, 0.3), PERIOD)))[:, :3, 3], axis=0), axis=1
    )
    assert np.median(speeds) / PERIOD == pytest.approx(0.04, rel=0.02)
    hasty = PLANNER.tool_path(joints_at(straight(0.002, 5, 0.5)[0]), straight(0.002, 5, 0.5), 10.0)
    joints = run(PathRunner(hasty, line_pace(10.0, 0.3), PERIOD))
    assert np.abs(np.diff(joints, axis=0)).max() <= 0.6 * RM65_LIMITS.speed.max() * PERIOD


@pytest.mark.parametrize("turn", [0.2, 0.4, -0.4])
def test_joints_are_not_jerked_where_the_skin_has_an_edge(turn):
    """Straight, over an edge within 8 mm, straight again: only the joints' own limits count then."""
    pieces = [straight(0.03, 16)]
    for length, count, bend in ((0.008, 5, turn), (0.03, 16, 0.0)):
        begin = pieces[-1][-1].copy()
        begin[:3, 3] += 0.5 * length * begin[:3, 1]
        pieces.append(straight(length, count, bend, begin)[1:])
    poses = np.concatenate(pieces)
    path = PLANNER.tool_path(joints_at(poses[0]), poses, 0.04)
    joints = run(PathRunner(path, line_pace(0.1, 0.3), PERIOD))
    acceleration = np.abs(np.diff(joints, 2, axis=0)).max() / PERIOD**2
    assert acceleration < np.radians(350.0)


def test_braking_stops_on_the_path_and_going_on_reaches_the_end():
    runner = PathRunner(
        PLANNER.tool_path(joints_at(straight(0.1)[0]), straight(0.1), 0.05), line_pace(0.05, 0.3), PERIOD
    )
    for _ in range(80):
        runner.step()
    assert runner.speed > 0.04
    at = runner.length
    runner.brake(line_pace(0.0, 2.0))
    for _ in range(60):
        runner.step()
    assert runner.at_rest
    assert 0.0 < runner.length - at < 0.01
    runner.go_on(line_pace(0.05, 0.3))
    run(runner)
    assert runner.length == pytest.approx(runner.path.end, abs=1e-6)


def test_way_back_ends_where_it_came_from():
    path = PLANNER.joint_path(HOME, TOUCH)
    back = path.back_from(1.0, 0.4)
    assert_allclose(back.joints[0], path.at(1.0), atol=1e-9)
    assert_allclose(back.joints[-1], path.at(0.6), atol=1e-9)
    assert_allclose(path.back_from(0.1, 5.0).joints[-1], HOME, atol=1e-9)


@pytest.mark.parametrize("seed", [1, 6, 31, 32, 43, 48])
def test_an_edge_passed_as_slowly_as_rest_is_no_stand(seed):
    """Where the speed allowed changes before an edge, braking may undershoot: s rests for a moment."""
    rng, distances = np.random.default_rng(seed), 0.001 * np.arange(120)
    joints = np.cumsum(rng.normal(0.0, 0.002, (120, 6)), axis=0) * rng.choice([0.2, 1.0, 3.0])
    edge = rng.integers(20, 100)
    joints[edge:] += np.outer(np.arange(120 - edge), rng.normal(0.0, 0.01, 6))
    path = timed_tool_path(distances, joints, LINE_DECELERATION, RM65_LIMITS, 0.5, np.full(120, 0.04))
    runner, rests = PathRunner(path, line_pace(0.1, 0.3), PERIOD), 0
    runner.share = rng.uniform(0.25, 1.0)
    while not runner.at_end:
        runner.step()
        runner.share = rng.uniform(0.25, 1.0) if rng.random() < 0.1 else runner.share
        rests += runner.at_rest and not runner.at_end
        assert runner.stands == runner.at_end
    assert rests  # or this test shows nothing
    assert runner.length == pytest.approx(path.end, abs=1e-6)


def test_a_speed_a_hair_below_zero_is_no_end():
    """Braking hard before a corner may undershoot standstill."""
    runner = PathRunner(PLANNER.joint_path(HOME, TOUCH), JOINT_PACE, PERIOD)
    for _ in range(50):
        runner.step()
    runner.speed = -1e-3
    run(runner)
    assert runner.length == pytest.approx(runner.path.end, abs=1e-6)
