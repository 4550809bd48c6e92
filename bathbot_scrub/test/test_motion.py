"""Joint paths, their timing, and the planner of free motions."""

import numpy as np
import pytest
from bathbot_depthcorr.rigid import rotation_angle, transform_from
from bathbot_scrub.rm65.errors import JointLimitError, NotReadyError, UnreachableError
from bathbot_scrub.rm65.inverse_kinematics import nearest, solve_head
from bathbot_scrub.rm65.joint_path import densify, joint_move, solve_path, timed_path
from bathbot_scrub.rm65.kinematics import HEAD_LENGTH, Kinematics
from bathbot_scrub.rm65.limits import RM65_LIMITS
from bathbot_scrub.rm65.motion import Planner, line_pace, retreated
from bathbot_scrub.rm65.path_runner import Pace, PathRunner
from bathbot_scrub.rm65.period import Beat, PeriodStatistics
from bathbot_scrub.rm65.segment_queue import ScrubPath, Segment
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

ARM = Kinematics("6F")
HOME = np.radians([0.0, 60.0, -130.0, 0.0, -80.0, 0.0])
JOINT_PACE = Pace(1.0, 2.0, 20.0)
PLANNER = Planner(ARM, HOME, JOINT_PACE, 0.5)
PERIOD = 0.01


def facing(position, yaw=0.0, pitch=0.0, roll=0.0):
    """Head pose whose z axis points along x, turned by yaw and pitch [deg]."""
    turn = Rotation.from_euler("zyx", [yaw, 90.0 + pitch, roll], degrees=True).as_matrix()
    return transform_from(turn, position)


TARGET = facing((0.57, 0.0, 0.2), yaw=-25.0, pitch=5.0)
TOUCH = nearest(solve_head(ARM, TARGET), np.radians([0, -60, -90, 0, 60, 0]))


def straight(length=0.1, count=51, turn=0.0, start=TARGET):
    """Head poses along y of the head, with z turning by `turn` [rad] in all."""
    poses = np.tile(start, (count, 1, 1))
    share = np.linspace(0.0, 1.0, count)
    poses[:, :3, 3] += (length * (share - 0.5))[:, None] * start[:3, 1]
    poses[:, :3, :3] = start[:3, :3] @ Rotation.from_euler("y", (turn * share)[:, None]).as_matrix()
    return poses


def joints_at(pose):
    """Joints that hold the head at a pose, on the branch of the tests."""
    return nearest(solve_head(ARM, pose), TOUCH)


def run(runner, most=3000):
    """Joints after every period until the end."""
    joints = [runner.path.at(runner.length)]
    while not runner.at_end:
        joints.append(runner.step())
        assert len(joints) < most
    return np.array(joints)


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


def test_a_joint_move_beyond_the_limits_is_refused():
    with pytest.raises(JointLimitError, match="joint 3"):
        joint_move(HOME, np.radians([0.0, 0.0, 140.0, 0.0, 0.0, 0.0]))


def test_a_corner_is_passed_slowly():
    lengths, joints = joint_move(np.zeros(6), np.full(6, 0.5), np.array([1.0, 0.0, 0.5, 0.5, 0.5, 0.5]))
    path = timed_path(lengths, joints, 2.0, RM65_LIMITS, 1.0)
    assert path.speed_at(0.5) < 0.3 * path.speed_at(0.05)


def test_speed_limit_leaves_room_to_brake():
    lengths, joints = joint_move(np.zeros(6), np.full(6, 0.5), np.array([1.0, 0.0, 0.5, 0.5, 0.5, 0.5]))
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
        return
    assert_allclose(ARM.head(path.joints[-1]), standoff, atol=1e-6)
    frames = ARM.link_frames(path.joints)
    tips = frames[:, 6, :3, 3] + HEAD_LENGTH * frames[:, 6, :3, 2]
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
    heads = frames[:, 6, :3, 3] + HEAD_LENGTH * frames[:, 6, :3, 2]
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


def test_a_far_beginning_is_reached_over_the_skin():
    first = TARGET.copy()
    first[:3, 3] += 0.08 * TARGET[:3, 1]
    poses = PLANNER.lead_in(TARGET, first, 0.03, 0.35)
    height = (poses[:, :3, 3] - TARGET[:3, 3]) @ -TARGET[:3, 2]
    assert_allclose(height, [0.0, 0.03, 0.03, 0.0], atol=1e-12)
    with pytest.raises(UnreachableError, match="approach its start"):
        PLANNER.lead_in(TARGET, first, 0.03, 0.05)


def segment(index, last=False, path_id=1, poses=None, speed=0.04):
    chunk = straight(0.12, 61)[20 * index : 20 * index + 21] if poses is None else poses
    return Segment(path_id, index, last, "Trunk_skin", chunk, speed)


def scrub_path():
    first = straight(0.12, 61)[0]
    return ScrubPath(segment(0), PLANNER, joints_at(first), np.stack([first, first]), 0.1)


def test_segments_join_without_a_gap_and_are_counted():
    path = scrub_path()
    before = path.path
    after = path.extend(segment(1))
    assert_allclose(after.joints[: len(before.joints)], before.joints)
    path.extend(segment(2, last=True))
    assert path.path.end == pytest.approx(0.12, abs=1e-6)
    assert [path.segment_at(s) for s in (0.0, 0.041, 0.12)] == [0, 1, 2]
    assert [path.queued_at(s) for s in (0.0, 0.041, 0.12)] == [3, 2, 0]
    assert path.finished
    assert [path.travelled_at(s) for s in (0.0, 0.041, 0.12)] == pytest.approx([0.0, 0.041, 0.12])


def test_the_way_along_a_path_is_counted_without_the_turns():
    poses = straight(0.02, 11, 0.6)
    path = ScrubPath(segment(0, True, poses=poses), PLANNER, joints_at(poses[0]), poses[[0, 0]], 0.1)
    assert path.path.end > 0.05
    assert path.travelled_at(path.path.end) == pytest.approx(0.02, abs=1e-6)


@pytest.mark.parametrize(
    ("wrong", "error"),
    [
        pytest.param(segment(2), "in order", id="skipped"),
        pytest.param(segment(0), "in order", id="again"),
        pytest.param(segment(1, path_id=2), "in order", id="other path"),
        pytest.param(segment(1, poses=np.full((3, 4, 4), np.nan)), "not finite", id="not a number"),
        pytest.param(segment(1, poses=straight(0.12, 61)[50:]), "m apart", id="gap"),
        pytest.param(segment(1, speed=np.nan), "speed", id="speed"),
        pytest.param(segment(1, poses=np.zeros((0, 4, 4))), "no poses", id="empty"),
    ],
)
def test_a_wrong_segment_is_refused_whole(wrong, error):
    path = scrub_path()
    end = path.path.end
    with pytest.raises((NotReadyError, UnreachableError, Exception), match=error):
        path.extend(wrong)
    assert path.path.end == end
    path.extend(segment(1))


def test_period_statistics_tell_the_deviation():
    statistics = PeriodStatistics(0.01)
    for now in (0.0, 0.01, 0.02, 0.032, 0.06):
        statistics.tick(now)
    assert statistics.p99() == pytest.approx(0.018, abs=5e-4)
    assert statistics.missed == 1
    statistics.pause()
    statistics.tick(100.0)
    assert statistics.missed == 1


def test_the_beat_does_not_drift():
    import time

    beat, begin = Beat(0.002), time.monotonic()
    for _ in range(50):
        beat.wait()
    assert time.monotonic() - begin >= 50 * 0.002 - 1e-3
