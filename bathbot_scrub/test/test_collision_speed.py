"""Speeds near people: what a body bears to be hit, what the bristles bear to meet it, and where they hold."""

import numpy as np
import pytest
from arm_poses import ARM, HOME, JOINT_PACE, TARGET, joints_at
from bathbot_scrub.arm.clearance import capsule_ends
from bathbot_scrub.arm.collision_speed import collision_speed, meeting_speed
from bathbot_scrub.arm.collision_table import PARTS
from bathbot_scrub.arm.tool_path import retreated
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner
from bathbot_scrub.rm65.paths.path_runner import Pace, PathRunner
from bathbot_scrub.rm65.paths.speed_near_people import LEAN, speeds_near_people
from bathbot_scrub.rm65.paths.surroundings import Surroundings
from bathbot_scrub.rm65.settings import DriverSettings
from hypothesis import given
from hypothesis import strategies as st

SETTINGS = DriverSettings()
SPEEDS = speeds_near_people(ARM)
SKIN = 0.4 * np.indices((41, 41)).reshape(2, -1).T / 40 - 0.2  # points 1 cm apart on a square [m]
STEP = 0.01  # [s]


def test_a_face_by_hand():
    """m_R = 7.2/2 + 0.35 = 3.95 kg, mu = 1/(1/4.4 + 1/3.95) = 2.0814 kg, v = 65 N / sqrt(mu 75 kN/m)."""
    assert collision_speed("Face_skin", 7.2, 0.35) == pytest.approx(0.16451, abs=1e-5)


def test_who_is_not_known_is_the_gentlest_and_a_heavier_arm_is_slower():
    assert collision_speed("", 7.2, 0.35) == min(collision_speed(region, 7.2, 0.35) for region in PARTS)
    for region in PARTS:
        assert collision_speed(region, 14.0, 0.35) < collision_speed(region, 7.2, 0.35)


@given(
    room=st.floats(0.002, 0.02), delay=st.floats(0.005, 0.1), slower=st.floats(1, 20), body=st.floats(0, 0.1)
)
def test_a_head_that_meets_someone_at_that_speed_just_does_not_use_its_bristles_up(room, delay, slower, body):
    speed = meeting_speed(room, delay, slower, body)
    closing = speed + body
    used = closing * delay + closing**2 / (2.0 * slower)
    assert used == pytest.approx(room) if speed else used >= room * (1.0 - 1e-9)


def cell(points=None):
    around = Surroundings(ARM, SETTINGS, lambda: 100.0)
    if points is not None:
        around.see(points, 100.0)
    return MotionPlanner(ARM, HOME, JOINT_PACE, 0.5, surroundings=around)


def skin(beyond=0.0):
    return TARGET[:3, 3] + SKIN @ TARGET[:3, :2].T + beyond * TARGET[:3, 2]


def run(path, pace=JOINT_PACE):
    """Joints every hundredth of a second."""
    runner = PathRunner(path, pace, STEP)
    joints = [path.joints[0]]
    while not runner.at_end:
        joints.append(runner.step())
        assert len(joints) < 6000
    return np.array(joints)


def speeds(joints):
    """Of the fastest point of each capsule [m/s], shape (N - 1, C)."""
    ends = capsule_ends(ARM, ARM.shape.moving, joints)
    return np.linalg.norm(np.diff(ends, axis=0), axis=-1).max(-1) / STEP


@pytest.mark.parametrize("seen", [True, False])
@pytest.mark.parametrize("homewards", [False, True])
def test_near_people_nothing_is_faster_than_they_bear(seen, homewards):
    planner = cell(skin() if seen else None)
    way = planner.to_pose(HOME, retreated(TARGET, 0.06), TARGET[None, :3, 3])
    if homewards:
        way = planner.to_home(way.joints[-1], way)
    joints = run(way)
    apart = np.full((len(joints), len(ARM.shape.moving)), 0.0)
    if seen:  # each capsule from the plane, plain geometry
        ends = capsule_ends(ARM, ARM.shape.moving, joints)
        heights = ((TARGET[:3, 3] - ends) @ TARGET[:3, 2]).min(-1)
        apart = heights - np.array([capsule.radius for capsule in ARM.shape.moving])
    near = apart[1:] < LEAN - 0.05  # the square of skin is no whole plane
    assert near.any()
    assert speeds(joints)[near].max() <= 1.05 * SPEEDS.links
    towards = np.diff(ARM.head(joints)[:, :3, 3] @ TARGET[:3, 2]) / STEP
    assert towards[near[:, -1]].max() <= 1.15 * SPEEDS.meeting


def test_a_head_that_draws_back_is_only_bound_as_the_links_are():
    planner = cell()
    line = planner.line(joints_at(TARGET), -0.10, 1.0).joints
    path = planner.slow_near_people(planner.joint_path(line[0], *line[1:]))
    fastest = speeds(run(path, Pace(3.0, 10.0, 1000.0))).max()  # joints that could do more
    assert 0.9 * SPEEDS.links <= fastest <= 1.05 * SPEEDS.links


def test_far_from_everybody_the_arm_is_as_fast_as_ever():
    free, planner = cell(skin(beyond=2.0)), cell(skin(beyond=2.0))
    start, goal = HOME, HOME + 0.5
    path = planner.slow_near_people(planner.joint_path(start, goal))
    assert len(run(path)) == len(run(free.joint_path(start, goal)))


def test_a_cloud_that_is_too_old_tells_nothing():
    now = 100.0
    around = Surroundings(ARM, SETTINGS, lambda: now)
    planner = MotionPlanner(ARM, HOME, JOINT_PACE, 0.5, surroundings=around)
    around.see(skin(beyond=2.0), now)
    path = planner.joint_path(HOME, HOME + 0.3)
    known = around.caps(path.lengths, path.joints)
    now += SETTINGS.body_max_age + 1.0
    assert np.isinf(known).all()
    assert np.isfinite(around.caps(path.lengths, path.joints)).all()
