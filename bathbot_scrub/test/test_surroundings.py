"""Paths against the arm itself, walls and a body: what is met is found, what is not met is let through."""

import numpy as np
import pytest
from arm_poses import ARM, HOME, JOINT_PACE, TARGET, TOUCH, facing, straight
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from bathbot_scrub.arm.clearance import capsule_ends, swept
from bathbot_scrub.arm.clearance_kernel import fill_clearances, within
from bathbot_scrub.arm.errors import CollisionError, NotReadyError, UnreachableError
from bathbot_scrub.arm.tool_path import densify, retreated, solve_path
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.motion.scrub_path import ScrubPath
from bathbot_scrub.rm65.paths.joint_path import joint_move
from bathbot_scrub.rm65.paths.motion_planner import MotionPlanner
from bathbot_scrub.rm65.paths.surroundings import Surroundings
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.segment.segment import Segment
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

SETTINGS = DriverSettings()
SKIN = 0.4 * np.indices((41, 41)).reshape(2, -1).T / 40 - 0.2  # points 1 cm apart on a square [m]


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


def cell(points=None, clock=None, **changes):
    """Surroundings with a body just seen, and a planner among them."""
    clock = clock or Clock()
    around = Surroundings(ARM, DriverSettings(**changes), clock)
    if points is not None:
        around.see(points, clock.now)
    return around, MotionPlanner(ARM, HOME, JOINT_PACE, 0.5, surroundings=around)


def wall_of_skin(target, beyond=0.0):
    """Points of a flat body behind a target, across its z axis."""
    return target[:3, 3] + SKIN @ target[:3, :2].T + beyond * target[:3, 2]


def test_clearances_are_those_of_plain_geometry():
    rng = np.random.default_rng(1)
    ends, radii = rng.uniform(-1, 1, (12, 5, 2, 3)), rng.uniform(0.0, 0.1, 5)
    ends[0, 0, 1] = ends[0, 0, 0]  # a sphere
    points, spared, touches = rng.uniform(-1, 1, (400, 3)), rng.random(400) < 0.3, np.arange(5) > 2
    found = (np.empty(12), *np.empty((2, 12), int))
    fill_clearances(ends, radii, touches, points, spared, np.inf, *found)
    start, along = ends[:, :, None, 0], (ends[:, :, 1] - ends[:, :, 0])[:, :, None]
    with np.errstate(invalid="ignore"):
        share = np.nan_to_num(((points - start) * along).sum(-1) / (along**2).sum(-1)).clip(0.0, 1.0)
    apart = np.linalg.norm(points - start - share[..., None] * along, axis=-1) - radii[:, None]
    apart[:, touches[:, None] & spared[None]] = np.inf
    assert_allclose(found[0], apart.min(axis=(1, 2)), atol=1e-12)
    assert (found[1] == apart.min(axis=2).argmin(axis=1)).all()
    assert_allclose(apart[np.arange(12), found[1], found[2]], found[0], atol=1e-12)


def test_points_within_reach_of_a_place():
    points = np.array([[0.0, 0.0, 0.059], [0.0, 0.0, 0.061], [1.0, 0.0, 0.0]])
    assert within(points, np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.05]]), 0.06).tolist() == [True, False, True]
    assert not within(points, np.empty((0, 3)), 0.06).any()


postures = st.lists(st.floats(-1.8, 1.8), min_size=6, max_size=6).map(np.array)


@given(
    begin=postures, end=postures, share=st.floats(0.0, 1.0), part=st.integers(0, 6), at=st.floats(0.0, 1.0)
)
@settings(max_examples=60, deadline=None)
def test_nothing_on_the_way_is_stepped_over(begin, end, share, part, at):
    """One point on the axis of a link, at any moment of a path, is always met."""
    assume(np.abs(end - begin).max() > 1e-3)
    capsules = RM65("6F").shape.moving
    joints = joint_move(begin, end, limits=RM65_LIMITS)[1]
    path = swept(ARM, tuple(capsules), joints)
    assert_allclose(path.joints[[0, -1]], joints[[0, -1]])
    moment = swept(ARM, tuple(capsules), np.repeat((begin + share * (end - begin))[None], 2, 0))
    place = moment.ends[0, part, 0] + at * (moment.ends[0, part, 1] - moment.ends[0, part, 0])
    found = (np.empty(len(path.ends)), *np.empty((2, len(path.ends)), int))
    radii = np.array([c.radius for c in capsules])
    fill_clearances(path.ends, radii, np.zeros(7, bool), place[None], np.zeros(1, bool), 1.0, *found)
    assert (found[0] - path.stray).min() < -radii[part] + 1e-3
    assert path.stray.max() < 0.02


def test_an_approach_in_free_air_is_as_without_surroundings():
    around, planner = cell(wall_of_skin(TARGET))
    way, line = planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)
    assert_allclose(ARM.head(way.joints[-1]), retreated(TARGET, 0.06), atol=1e-9)
    assert_allclose(ARM.head(line.joints[-1]), retreated(TARGET, -0.012), atol=1e-9)
    assert_allclose(planner.to_home(way.joints[-1], way).joints[-1], HOME, atol=1e-9)
    assert around.status() == "1681 points, 0.0 s old"


def test_what_is_in_the_way_is_named_with_place_and_distance():
    around, planner = cell()
    line = planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)[1]
    early, late = ARM.link_frames(line.joints[[0, -1]])[:, 3, :3, 3]  # of the elbow
    ahead = (late - early) / np.linalg.norm(late - early)
    around.see([late + 0.056 * ahead, late + 0.5 * ahead], Clock.now)
    with pytest.raises(
        CollisionError, match=r"Link\d would .* the body at \(.*, the least allowed is 15 mm"
    ) as caught:
        around.check(line.joints, TARGET[:3, 3], 0.015)
    assert caught.value.link in ("Link2", "Link3")
    assert caught.value.distance < 0.015 == caught.value.allowed


def test_another_posture_is_taken_where_the_first_would_meet_something():
    target = facing((0.40, 0.20, 0.35))
    around, planner = cell()
    first = planner.to_pose(HOME, retreated(target, 0.06))
    elbow = ARM.link_frames(first.joints[-1])[3, :3, 3]
    around.see(elbow[None], Clock.now)
    other = planner.to_pose(HOME, retreated(target, 0.06))
    assert_allclose(ARM.head(other.joints[-1]), retreated(target, 0.06), atol=1e-9)
    assert np.abs(other.joints[-1] - first.joints[-1]).max() > 0.5
    assert np.linalg.norm(ARM.link_frames(other.joints)[:, 3, :3, 3] - elbow, axis=-1).min() > 0.05


def test_a_body_all_round_is_a_refusal_before_any_motion():
    rng = np.random.default_rng(0)
    shell = rng.normal(size=(4000, 3))
    shell = (0.0, 0.0, 0.2405) + 0.40 * shell / np.linalg.norm(shell, axis=1, keepdims=True)
    shell = shell[shell[:, 0] > 0.1]
    _, planner = cell(shell)
    with pytest.raises(CollisionError, match="the body at"):
        planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)


def test_only_the_head_may_touch_and_only_in_the_patch():
    around, planner = cell()
    line = planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)[1]
    around.see(wall_of_skin(TARGET), Clock.now)
    around.check(line.joints, TARGET[:3, 3], 0.015)  # flat skin round the target
    with pytest.raises(CollisionError, match="scrub_head"):
        around.check(line.joints, (), 0.015)  # the same, nothing spared
    beside = TARGET[:3, 3] - 0.09 * TARGET[:3, 2] + 0.03 * TARGET[:3, 0]  # a finger over the handle
    around.see(beside[None], Clock.now)
    with pytest.raises(CollisionError, match=r"scrub_head|Link6"):
        around.check(line.joints, TARGET[:3, 3], 0.015)


def test_who_stands_too_near_may_leave_but_not_come_nearer():
    around, planner = cell()
    line = planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)[1]
    tip = ARM.head(line.joints[0])
    beside = (
        tip[:3, 3] + (SCRUB_HEAD.brush_radius + 0.004) * tip[:3, 0] - SCRUB_HEAD.brush_radius * tip[:3, 2]
    )
    around.see(beside[None], Clock.now)
    around.check(planner.line(line.joints[0], -0.05, 0.1).joints, (), 0.015)
    beside_tool = joint_move(line.joints[0], line.joints[0] + 0.05 * np.eye(6)[0], limits=RM65_LIMITS)[1]
    away, nearer = (beside_tool, 2 * beside_tool[0] - beside_tool)
    if ARM.head(away[-1])[:3, 3] @ tip[:3, 0] > tip[:3, 3] @ tip[:3, 0]:
        away, nearer = nearer, away
    around.check(away, (), 0.015)
    with pytest.raises(CollisionError):
        around.check(nearer, (), 0.015)


@pytest.mark.parametrize("apart", [0.0151, 0.016, 0.017, 0.0175, 0.02])
def test_who_stands_at_little_more_than_the_margin_may_go_away(apart):
    """Between two samples of any path the arm may stray by 2.5 mm: at 17 mm it was refused every way."""
    around, planner = cell()
    ends, radii = capsule_ends(ARM, ARM.shape.moving, TOUCH[None])[0], [c.radius for c in ARM.shape.moving]
    z = TARGET[:3, 2]
    foremost = int(np.argmax((ends @ z).max(axis=1) + radii))
    place = ends[foremost][(ends[foremost] @ z).argmax()] + (radii[foremost] + apart) * z
    around.see(place[None], 100.0)
    assert around.free_part(TOUCH[None], (), 0.015) == 1
    around.check_body(planner.line(TOUCH, -0.05, 0.1).joints, (), 0.015)
    with pytest.raises(CollisionError):
        around.check_body(planner.line(TOUCH, 0.01, 0.1).joints, (), 0.015)


def test_standing_beside_one_thing_excuses_no_other():
    around, planner = cell()
    start = planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)[0].joints[-1]
    path = joint_move(start, start + 0.3 * np.eye(6)[0], limits=RM65_LIMITS)[1]
    forearm = ARM.link_frames(path[[0, -1]])[:, 4, :3, 3]
    ahead = (forearm[1] - forearm[0]) / np.linalg.norm(forearm[1] - forearm[0])
    inside = forearm[0] - 0.03 * ahead  # in the arm already, and left behind
    around.see(inside[None], Clock.now)
    around.check(path, (), 0.015)
    around.see([inside, forearm[1] + 0.045 * ahead], Clock.now)
    with pytest.raises(CollisionError, match=r"Link[45]"):
        around.check(path, (), 0.015)


def test_the_arm_does_not_run_into_itself_or_a_wall():
    around, _ = cell()
    folded = np.radians([0.0, 0.0, -135.0, 0.0, -128.0, 0.0])
    into_itself = joint_move(np.zeros(6), folded, limits=RM65_LIMITS)[1]
    with pytest.raises(CollisionError, match=r"Link|scrub_head"):
        around.check(into_itself, (), 0.015)
    low = joint_move(HOME, np.radians([0.0, -120.0, 0.0, 0.0, 0.0, 0.0]), limits=RM65_LIMITS)[1]
    around.check(low[:3], (), 0.015)
    around, _ = cell(walls=(0.0, 0.0, 1.0, -0.1))
    with pytest.raises(CollisionError, match=r"the wall at \(0, 0, 1\)"):
        around.check(low, (), 0.015)


@given(at=st.tuples(*3 * [st.floats(-0.15, 0.15)]), share=st.floats(0.0, 1.0))
@settings(max_examples=100, deadline=None)
def test_the_free_part_of_a_path_is_clear_and_no_longer_part_is(at, share):
    """As the check of whole paths says, which a point anywhere about the arm's way is held against."""
    around, planner = cell()
    joints = planner.line(TOUCH, -0.10, 0.25).joints
    elbow = ARM.link_frames(joints[int(share * (len(joints) - 1))])[3, :3, 3]
    around.see((elbow + at)[None], 100.0)
    free = around.free_part(joints, (), 0.015)
    if free > 1:
        around.check_body(joints[:free], (), 0.015)
    if free < len(joints):
        behind_the_next_sample = free + 6  # three joints to it, as many on
        with pytest.raises(CollisionError):
            around.check_body(joints[:behind_the_next_sample], (), 0.015)


def test_a_body_seen_too_long_ago_keeps_the_arm_away_but_lets_it_home():
    clock = Clock()
    around, planner = cell(wall_of_skin(TARGET), clock)
    way, _ = planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)
    clock.now += SETTINGS.body_max_age + 1.0
    with pytest.raises(NotReadyError, match=r"seen 6\.0 s ago"):
        planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)
    assert "too old" in around.status()
    assert_allclose(planner.to_home(way.joints[-1], way).joints[-1], HOME, atol=1e-9)


def test_a_wrist_wound_to_its_stop_goes_home_by_the_stand_off_it_came_from():
    """Over the skin joint 5 would pass its stop, and folded as it stands the wrist meets the base."""
    around, planner = cell()
    standoff = np.radians([40.47, -84.37, -118.67, -120.61, -116.00, 110.22])
    start = np.radians([39.13, -89.69, -132.13, -124.35, -117.54, -55.97])
    came = planner.to_pose(HOME, ARM.head(standoff))
    assert_allclose(came.joints[-1], standoff, atol=1e-6)
    path = planner.to_home(start, came)
    assert_allclose(path.joints[[0, -1]], [start, HOME], atol=1e-9)
    around.check(path.joints, ARM.head(start)[None, :3, 3], around.margin)
    side = ARM.head(start)
    assert ((ARM.head(path.joints)[:, :3, 3] - side[:3, 3]) @ side[:3, 2]).max() < 0.05
    assert np.abs(path.joints - standoff).max(1).min() < 1e-3


def test_no_way_home_names_each_way_that_was_tried():
    """One obstacle alone would send a person to the wrong place."""
    _, planner = cell()
    start = np.radians([39.13, -89.69, -132.13, -124.35, -117.54, -55.97])
    elsewhere = planner.joint_path(start + 0.1, start)
    with pytest.raises(UnreachableError) as refused:
        planner.to_home(start, elsewhere)
    said = str(refused.value)
    assert said.startswith("no way home: ")
    assert "as it came, by its stand-off: the arm did not come from home" in said
    assert said.count("did not come from home") == 1
    assert "folding first: Link1 would run into Link6" in said


@pytest.mark.parametrize("nothing", [np.empty((0, 3)), np.full((7, 3), np.nan)], ids=["empty", "not numbers"])
def test_an_empty_cloud_is_unknown_not_free(nothing):
    """The lens is covered: no way to the person, and all other ways keep off where the body was seen last."""
    clock = Clock()
    around, planner = cell(wall_of_skin(TARGET), clock)
    line = planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)[1]
    around.see(nothing, clock.now)
    with pytest.raises(NotReadyError, match="the body cloud is empty"):
        planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)
    for later in (0.0, 600.0):
        clock.now += later
        with pytest.raises(CollisionError, match="the body at"):
            around.check(line.joints, (), 0.015)
    around.see(wall_of_skin(TARGET), clock.now)
    planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)


def test_a_first_cloud_that_is_empty_is_unknown_too():
    around, planner = cell(np.empty((0, 3)))
    with pytest.raises(NotReadyError, match="nobody knows where the person is"):
        planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)
    assert "empty" in around.status()


def test_a_body_of_long_ago_stays_where_it_was():
    """Silence is not absence: a way home keeps off the last points, however old."""
    clock = Clock()
    around, planner = cell(wall_of_skin(TARGET), clock)
    line = planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)[1]
    clock.now += 3600.0
    with pytest.raises(CollisionError, match="the body at"):
        around.check(line.joints, (), 0.015)


def test_without_a_body_the_arm_moves_and_says_so():
    around, planner = cell()
    planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)
    assert "no body cloud" in around.status()


def test_a_segment_beside_an_obstacle_is_refused_and_the_path_stays_as_it_was():
    around, planner = cell()
    poses = straight(0.08, 41)
    joints = solve_path(ARM, densify(poses)[1], TOUCH)
    path = ScrubPath(Segment(1, 0, False, "Trunk_skin", poses[:20], 0.05), planner, joints[0], poses[:2], 0.1)
    end = path.path.end
    link6 = ARM.link_frames(joints[-1])[6, :3, 3] - 0.05 * poses[-1, :3, 2]
    around.see((link6 + 0.037 * poses[-1, :3, 1])[None], Clock.now)
    with pytest.raises(CollisionError, match="Link6"):
        path.extend(Segment(1, 1, True, "Trunk_skin", poses[20:], 0.05))
    assert path.path.end == end
    around.see(wall_of_skin(TARGET), Clock.now)
    path.extend(Segment(1, 1, True, "Trunk_skin", poses[20:], 0.05))
    assert path.path.end > end


def test_retracting_asks_nobody():
    around, planner = cell()
    line = planner.to_touch(HOME, TARGET, 0.06, 0.012, 0.03)[1]
    around.see(np.linspace(ARM.head(line.joints[-1])[:3, 3], (0.0, 0.0, 0.3), 100), Clock.now)
    assert planner.line(line.joints[-1], -0.10, 0.25, 0.02).end > 0.0


def test_out_of_reach_is_still_told_as_such():
    with pytest.raises(UnreachableError, match="m from the shoulder"):
        cell()[1].to_touch(HOME, facing((1.0, 0.0, 0.2)), 0.06, 0.012, 0.03)
