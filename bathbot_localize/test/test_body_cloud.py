"""The coarse cloud: on the body, without the arm, and it remembers what the arm hides."""

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from bathbot_localize.arm.arm_mask import near_arm
from bathbot_localize.target.body_cloud import BodyCloud
from bathbot_localize.target.localizer import make_frame
from hypothesis import given, settings
from hypothesis import strategies as st
from localize_scene import (
    COLOUR,
    DEPTH,
    T_BASE_COLOUR,
    T_BASE_DEPTH,
    T_COLOUR_DEPTH,
    plane,
    render,
    rod,
    sphere,
)
from rm65_links import SHAPE, links_of

CENTRE, RADIUS, VOXEL = np.array([0.5, 0.05, 0.15]), 0.12, 0.02
BALL, FLOOR = sphere(CENTRE, RADIUS), plane((0.0, 0.0, -0.75), (0.0, 0.0, 1.0))
FOLDED = links_of(np.radians([0.0, 60.0, -130.0, 0.0, -80.0, 0.0]))
BEFORE = links_of(np.radians([45.0, -20.0, -80.0, 0.0, 0.0, 0.0]))  # between ball and camera


def shapes_of(links):
    return [
        rod(*transform_points(links[c.link], [c.start, c.end]), c.radius)
        for c in SHAPE.capsules
        if c.link in links
    ]


def look(links, *shapes):
    """A frame in which the arm stands before these shapes."""
    depth = render(*shapes, *shapes_of(links))
    return make_frame(depth, DEPTH, COLOUR, T_COLOUR_DEPTH, T_BASE_COLOUR, SHAPE, links)


def on_ball(points):
    return np.abs(np.linalg.norm(points - CENTRE, axis=-1) - RADIUS) < 0.004


def test_points_lie_on_what_is_seen_one_for_each_cell():
    points = BodyCloud(VOXEL, 60.0, 0.02).update(look(FOLDED, BALL, FLOOR), 1.0).points
    assert on_ball(points).all()  # the floor is out of reach, the arm left out
    assert len(np.unique(np.floor(points / VOXEL), axis=0)) == len(points)
    seen = np.pi * RADIUS**2  # of the ball's 4 pi r^2 the camera sees less than half
    assert seen / VOXEL**2 < len(points) < 3.0 * seen / VOXEL**2


def test_every_seen_place_has_a_point_near_it():
    frame = look(FOLDED, BALL)
    points = BodyCloud(VOXEL, 60.0, 0.02).update(frame, 1.0).points
    v, u = np.nonzero(np.isfinite(frame.depth))
    places = transform_points(T_BASE_DEPTH, DEPTH.deproject(np.stack([u, v], -1), frame.depth[v, u]))
    towards = (places - CENTRE) / RADIUS @ (T_BASE_DEPTH[:3, 3] - CENTRE)
    places = places[on_ball(places) & (towards > 0.3)]  # not along the edge of the ball
    apart = np.linalg.norm(places[:, None] - points[None], axis=-1).min(axis=1)
    assert apart.max() < 1.5 * VOXEL


def test_the_arm_is_not_in_it():
    points = BodyCloud(VOXEL, 60.0, 0.02).update(look(BEFORE, BALL), 1.0).points
    assert not near_arm(points, SHAPE.capsules, BEFORE, 0.03).any()


@pytest.mark.parametrize("skew", [-0.05, -0.025, 0.025, 0.05])
def test_a_moving_arm_leaves_no_place_behind_though_the_clocks_disagree(skew):
    """The joints at 1.5 rad/s: the head at over 1 m/s, four times as fast as near people."""

    def links_at(time):
        return links_of(np.radians([45.0, -20.0, -80.0, 0.0, 0.0, 0.0]) + time * 1.5)

    frame = look(links_at(skew), BALL)._replace(T_base_link=links_at(0.0))
    known = BodyCloud(VOXEL, 60.0, 0.02).update(frame, 1.0, [links_at(-0.05), links_at(0.05)])
    assert len(known.points) > 20
    assert on_ball(known.points).all()


def speck(frame, pixels=4):
    """The frame with a few pixels that show something in the air, as stereo does at an edge."""
    place = transform_points(inverse(T_BASE_DEPTH), np.add(CENTRE, (-0.1, -0.2, 0.1)))
    (u, v), depth = np.round(DEPTH.project(place)).astype(int), frame.depth.copy()
    depth[v : v + pixels, u : u + pixels] = place[2]
    return frame._replace(depth=depth)


def in_the_air(points):
    return (~on_ball(points)).sum()


def test_a_place_that_stands_alone_is_believed_when_two_pictures_in_a_row_show_it():
    cloud, clear = BodyCloud(VOXEL, 60.0, 0.02), look(FOLDED, BALL)
    cloud.update(clear, 0.0)
    assert in_the_air(cloud.update(speck(clear), 1.0).points) == 0
    assert in_the_air(cloud.update(clear, 2.0).points) == 0
    assert in_the_air(cloud.update(speck(clear), 3.0).points) == 0
    for stamp in (4.0, 5.0, 6.0):
        assert 1 <= in_the_air(cloud.update(speck(clear), stamp).points) <= 2


def test_what_is_larger_than_a_place_is_believed_at_once():
    clear = look(FOLDED, BALL)
    cloud = BodyCloud(VOXEL, 60.0, 0.02)
    cloud.update(clear, 0.0)
    assert in_the_air(cloud.update(speck(clear, 20), 1.0).points) > 3


def test_what_the_arm_hides_is_remembered():
    cloud = BodyCloud(VOXEL, 10.0, 0.02)
    all_of_it = len(cloud.update(look(FOLDED, BALL), 0.0).points)
    alone = len(BodyCloud(VOXEL, 10.0, 0.02).update(look(BEFORE, BALL), 1.0).points)
    assert alone < 0.8 * all_of_it  # the arm does hide some
    remembered = cloud.update(look(BEFORE, BALL), 1.0)
    assert 0.97 * all_of_it < len(remembered.points) < 1.1 * all_of_it
    assert remembered.stamp == 1.0


def shadowed(frame, width):
    """The frame as stereo sees it: no depth beside the arm, where one of the two cameras sees it only."""
    arm = ~(frame.depth > look(FOLDED, BALL).depth - 0.05) & np.isfinite(frame.depth)
    beside = np.any([np.roll(arm, -shift, axis=1) for shift in range(1, width + 1)], axis=0)
    return frame._replace(depth=np.where(beside & ~arm, np.nan, frame.depth).astype(np.float32))


def test_the_stereo_shadow_of_the_arm_is_the_arms_and_no_covered_lens():
    cloud = BodyCloud(VOXEL, 60.0, 0.02)
    cloud.update(look(FOLDED, BALL), 1.0)
    before = cloud.update(look(FOLDED, BALL), 2.0).points
    across = links_of(np.radians([35.0, -40.0, -100.0, 0.0, 0.0, 0.0]))
    known = cloud.update(shadowed(look(across, BALL), 40), 3.0)
    assert known.stamp == 3.0
    assert len(known.points) > 0.9 * len(before)


def test_what_the_arm_hides_for_too_long_is_unknown_not_free():
    cloud = BodyCloud(VOXEL, 10.0, 0.02)
    all_of_it = len(cloud.update(look(FOLDED, BALL), 0.0).points)
    assert cloud.update(look(BEFORE, BALL), 10.0).stamp == 10.0
    late = cloud.update(look(BEFORE, BALL), 10.5)
    assert len(late.points) > 0.97 * all_of_it
    assert late.stamp == 10.0
    assert late.unseen > 0.2
    assert cloud.update(look(FOLDED, BALL), 11.0).stamp == 11.0  # the arm has gone: all is seen again


def test_what_is_seen_to_have_gone_is_forgotten_at_once():
    cloud = BodyCloud(VOXEL, 60.0, 0.02)
    wall = plane((1.6, 0.0, 0.0), (-1.0, 0.0, 0.0))
    assert len(cloud.update(look(FOLDED, BALL, wall), 0.0).points) > 50
    assert len(cloud.update(look(FOLDED, wall), 1.0).points) < 3


def test_what_another_part_of_the_body_hides_stays_and_spoils_nothing():
    cloud, hand = BodyCloud(VOXEL, 10.0, 0.02), sphere(np.add(CENTRE, (-0.15, 0.05, 0.1)), 0.08)
    before = cloud.update(look(FOLDED, BALL), 0.0)
    for stamp in (1.0, 12.0):
        known = cloud.update(look(FOLDED, BALL, hand), stamp)
        apart = np.linalg.norm(before.points[:, None] - known.points[None], axis=-1).min(axis=1)
        assert apart.max() < 1.5 * VOXEL
        assert known.stamp == stamp


def test_a_moved_body_leaves_no_ghost():
    cloud = BodyCloud(VOXEL, 60.0, 0.02)
    wall = plane((1.6, 0.0, 0.0), (-1.0, 0.0, 0.0))
    cloud.update(look(FOLDED, BALL, wall), 0.0)
    moved = np.add(CENTRE, (0.0, -0.08, 0.0))
    points = cloud.update(look(FOLDED, sphere(moved, RADIUS), wall), 1.0).points
    here = inverse(T_BASE_DEPTH)
    before = transform_points(here, points)[:, 2] < transform_points(here, moved)[2] - RADIUS - 0.02
    assert not before.any()  # nothing is left in front of where it is now


def test_without_depth_there_is_nothing():
    known = BodyCloud(VOXEL, 60.0, 0.02).update(covered(look({}, BALL), 1.0), 0.0)
    assert known.points.shape == (0, 3)
    assert known.stamp == -np.inf


def covered(frame, share, by=np.nan):
    """A frame whose lens is covered from the left, over a share of the ball's width in the picture."""
    columns = np.flatnonzero(np.isfinite(frame.depth).any(axis=0))
    depth = frame.depth.copy()
    depth[:, : columns[0] + int(np.ceil(share * (columns[-1] + 1 - columns[0])))] = by
    return frame._replace(depth=depth)


@pytest.mark.parametrize("by", [np.nan, 0.06], ids=["no depth", "something on the lens"])
@pytest.mark.parametrize("share", [0.4, 1.0], ids=["in part", "wholly"])
@pytest.mark.parametrize("later", [1.0, 59.0, 61.0, 3600.0])
def test_a_covered_lens_renews_nothing_and_frees_nothing(share, by, later):
    """However long: the points stay, and the picture that vouches for them grows old."""
    cloud, frame = BodyCloud(VOXEL, 60.0, 0.02), look({}, BALL)
    before = cloud.update(frame, 100.0)
    for stamp in (100.0 + 0.5 * later, 100.0 + later):
        known = cloud.update(covered(frame, share, by), stamp)
        apart = np.linalg.norm(before.points[:, None] - known.points[None], axis=-1).min(axis=1)
        assert apart.max() < 1.5 * VOXEL
        assert known.stamp == 100.0
        assert known.unseen >= 0.25
    assert cloud.update(frame, 101.0 + later).stamp == 101.0 + later


def test_a_little_without_depth_spoils_no_picture_and_is_forgotten_in_the_end():
    cloud, frame = BodyCloud(VOXEL, 60.0, 0.02), look({}, BALL)
    all_of_it = len(cloud.update(frame, 0.0).points)
    known = cloud.update(covered(frame, 0.08), 1.0)
    assert known.stamp == 1.0
    assert 0.0 < known.unseen <= 0.1
    assert len(known.points) >= all_of_it - 2
    assert len(cloud.update(covered(frame, 0.08), 61.0).points) < all_of_it - 5


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_no_place_becomes_free_but_by_being_looked_through(seed):
    """Whatever is covered, in whatever order: while no picture vouches, every place stays."""
    rng = np.random.default_rng(seed)
    cloud, frame = BodyCloud(VOXEL, 5.0, 0.02), look({}, BALL)
    before, now = cloud.update(frame, 0.0), 0.0
    for _ in range(4):
        now += float(rng.uniform(0.1, 20.0))
        depth = np.where(rng.random(frame.depth.shape) < rng.uniform(0.0, 1.0), np.nan, frame.depth)
        known = cloud.update(frame._replace(depth=depth.astype(np.float32)), now)
        apart = np.linalg.norm(before.points[:, None] - known.points[None], axis=-1).min(axis=1)
        assert known.stamp == now or apart.max() < 1.74 * VOXEL  # in the same cell
        before = known
