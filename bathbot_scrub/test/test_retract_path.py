"""The way off the skin: as far as nothing is met; and braking that every joint can follow."""

import numpy as np
import pytest
from arm_poses import ARM, HOME, JOINT_PACE, PERIOD, TARGET, TOUCH, joints_at, straight
from bathbot_scrub.arm.errors import CollisionError
from bathbot_scrub.rm65.motion.commanded_motion import CommandedMotion, MotionKind
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner, line_pace
from bathbot_scrub.rm65.paths.retract_path import Retract, RetractPath
from bathbot_scrub.rm65.paths.surroundings import Surroundings
from bathbot_scrub.rm65.settings import DriverSettings
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

CONTROLLER = np.radians(600.0)  # [rad/s^2] that the controller lets joints have
RETRACT = Retract(0.10, 0.25)
FOLDED = np.array([0.72, -0.53, 2.34, 2.99, 0.83, 1.89])  # [rad] straight back joint 3 is at its limit


def retract_path():
    around = Surroundings(ARM, DriverSettings(), lambda: 100.0)
    return around, RetractPath(MotionPlanner(ARM, HOME, JOINT_PACE, 0.5, surroundings=around), RETRACT)


def distance_left(path):
    return float(np.linalg.norm(ARM.head(path.joints[-1])[:3, 3] - TARGET[:3, 3]))


def beside_the_elbow(joints):
    """A point that the forearm comes to when the arm stands at joints [rad], and is clear of now."""
    elbow, before = (ARM.link_frames(q)[3, :3, 3] for q in (joints, TOUCH))
    ahead = (elbow - before) / np.linalg.norm(elbow - before)
    return (elbow + 0.055 * ahead)[None]


def test_without_a_body_it_is_as_long_as_asked():
    assert distance_left(retract_path()[1].path(TOUCH)) == pytest.approx(RETRACT.distance, abs=1e-6)


def test_it_ends_before_what_is_behind_the_arm_and_what_is_elsewhere_does_not_matter():
    around, out = retract_path()
    free = out.path(TOUCH)
    around.see([[0.0, 0.9, 0.9]], 100.0)
    assert out.path(TOUCH).end == free.end
    around.see(beside_the_elbow(free.joints[-1]), 100.0)
    with pytest.raises(CollisionError):
        out.demand_free(free)
    part = out.path(TOUCH)
    out.demand_free(part)
    assert 0.02 <= distance_left(part) <= 0.8 * RETRACT.distance
    assert part.speed_limit[-1] <= 0.051  # it comes to rest there


def test_the_skin_is_left_whatever_is_behind_the_arm():
    around, out = retract_path()
    first = out.path(TOUCH).joints
    around.see(np.concatenate([beside_the_elbow(q) for q in first[5:]]), 100.0)
    part = out.path(TOUCH)
    assert 0.005 < distance_left(part) <= 0.02
    with pytest.raises(CollisionError):
        out.demand_free(part)


def test_a_way_that_was_ready_is_shortened_too():
    around, out = retract_path()
    around.see(beside_the_elbow(out.path(TOUCH).joints[-1]), 100.0)
    out.prepare(TOUCH)
    assert distance_left(out.path(TOUCH + 0.002)) <= 0.8 * RETRACT.distance


def test_whoever_comes_behind_the_arm_while_it_rests_is_seen():
    now = 100.0
    around = Surroundings(ARM, DriverSettings(), lambda: now)
    out = RetractPath(MotionPlanner(ARM, HOME, JOINT_PACE, 0.5, surroundings=around), RETRACT, lambda: now)
    out.prepare(TOUCH)
    around.see(beside_the_elbow(out.path(TOUCH).joints[-1]), now)
    now += 1.1
    out.prepare(TOUCH)
    assert distance_left(out.path(TOUCH)) <= 0.8 * RETRACT.distance


class CountedPlanner(MotionPlanner):
    """Counts the lines that were asked for."""

    lines = 0

    def line(self, *asked):
        CountedPlanner.lines += 1
        return super().line(*asked)


def counted():
    """A path off the skin whose clock goes on by a period at every look."""
    clock, CountedPlanner.lines = iter(100.0 + PERIOD * np.arange(1000)), 0
    return RetractPath(CountedPlanner(ARM, HOME, JOINT_PACE, 0.5), RETRACT, lambda: next(clock))


@pytest.mark.parametrize(("joints", "most"), [(FOLDED, 25), (TOUCH, 2)], ids=["no way", "a way"])
def test_what_has_been_planned_takes_no_more_of_the_loops_time(joints, most):
    """At rest, and where there is no line at all: that was looked for in every period, 15 ms at a time."""
    out = counted()
    for _ in range(100):
        out.prepare(joints)
    assert 1 <= CountedPlanner.lines <= most


def test_a_head_that_turns_has_its_way_out_ready_all_along():
    """At 1 rad/s; a period in three may plan, and asking for the way never does."""
    out = counted()
    for turned in np.arange(0.0, 0.4, 0.01):
        joints = TOUCH + turned * np.eye(6)[5]
        out.prepare(joints)
        before = CountedPlanner.lines
        path = out.path(joints)
        assert CountedPlanner.lines == before
        assert_allclose(path.joints[0], joints, atol=1e-12)
    assert CountedPlanner.lines <= 14


@given(turn=st.floats(-3.0, 3.0), speed=st.floats(0.01, 0.1), until=st.integers(5, 100))
@settings(max_examples=40, deadline=None)
def test_no_joint_is_told_to_stop_harder_than_it_can(turn, speed, until):
    """The head turns about its axis, fast, while it is slow: joint 6 must not overshoot and come back."""
    poses = straight(0.04, 81)
    poses[:, :3, :3] @= Rotation.from_euler("z", np.linspace(0.0, turn, 81)[:, None]).as_matrix()
    planner = MotionPlanner(ARM, HOME, JOINT_PACE, 0.5)
    path = planner.tool_path(joints_at(poses[0]), poses, speed)
    motion = CommandedMotion(RetractPath(planner, RETRACT), PERIOD, ARM.limits)
    motion.begin(path, line_pace(0.1, 0.3), MotionKind.SCRUB)
    joints = [motion.step() for _ in range(until)]
    motion.brake()
    while not motion.at_rest:
        joints.append(motion.step())
        assert len(joints) < until + 50
    told = np.diff(joints, 2, axis=0) / PERIOD**2  # with what the bend of the path adds
    assert np.abs(told[until - 2 :]).max(initial=0.0) <= 1.05 * CONTROLLER
