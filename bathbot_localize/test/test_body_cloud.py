"""The coarse cloud: on the body, without the arm, and it remembers what the arm hides."""

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from bathbot_localize.arm.arm_mask import near_arm
from bathbot_localize.target.body_cloud import BodyCloud
from bathbot_localize.target.localizer import make_frame
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
    points = BodyCloud(VOXEL, 60.0, 0.02).update(look(FOLDED, BALL, FLOOR), 1.0)
    assert on_ball(points).all()  # the floor is out of reach, the arm left out
    assert len(np.unique(np.floor(points / VOXEL), axis=0)) == len(points)
    seen = np.pi * RADIUS**2  # of the ball's 4 pi r^2 the camera sees less than half
    assert seen / VOXEL**2 < len(points) < 3.0 * seen / VOXEL**2


def test_every_seen_place_has_a_point_near_it():
    frame = look(FOLDED, BALL)
    points = BodyCloud(VOXEL, 60.0, 0.02).update(frame, 1.0)
    v, u = np.nonzero(np.isfinite(frame.depth))
    places = transform_points(T_BASE_DEPTH, DEPTH.deproject(np.stack([u, v], -1), frame.depth[v, u]))
    towards = (places - CENTRE) / RADIUS @ (T_BASE_DEPTH[:3, 3] - CENTRE)
    places = places[on_ball(places) & (towards > 0.3)]  # not along the edge of the ball
    apart = np.linalg.norm(places[:, None] - points[None], axis=-1).min(axis=1)
    assert apart.max() < 1.5 * VOXEL


def test_the_arm_is_not_in_it():
    points = BodyCloud(VOXEL, 60.0, 0.02).update(look(BEFORE, BALL), 1.0)
    assert not near_arm(points, SHAPE.capsules, BEFORE, 0.03).any()


def test_what_the_arm_hides_is_remembered_for_a_while():
    cloud = BodyCloud(VOXEL, 10.0, 0.02)
    all_of_it = len(cloud.update(look(FOLDED, BALL), 0.0))
    alone = len(BodyCloud(VOXEL, 10.0, 0.02).update(look(BEFORE, BALL), 1.0))
    assert alone < 0.8 * all_of_it  # the arm does hide some
    remembered = cloud.update(look(BEFORE, BALL), 1.0)
    assert 0.97 * all_of_it < len(remembered) < 1.1 * all_of_it
    assert len(cloud.update(look(BEFORE, BALL), 11.5)) == pytest.approx(alone, abs=0.05 * all_of_it)


def test_what_is_seen_to_have_gone_is_forgotten_at_once():
    cloud = BodyCloud(VOXEL, 60.0, 0.02)
    wall = plane((1.6, 0.0, 0.0), (-1.0, 0.0, 0.0))
    assert len(cloud.update(look(FOLDED, BALL, wall), 0.0)) > 50
    assert len(cloud.update(look(FOLDED, wall), 1.0)) < 3


def test_a_moved_body_leaves_no_ghost():
    cloud = BodyCloud(VOXEL, 60.0, 0.02)
    wall = plane((1.6, 0.0, 0.0), (-1.0, 0.0, 0.0))
    cloud.update(look(FOLDED, BALL, wall), 0.0)
    moved = np.add(CENTRE, (0.0, -0.08, 0.0))
    points = cloud.update(look(FOLDED, sphere(moved, RADIUS), wall), 1.0)
    here = inverse(T_BASE_DEPTH)
    before = transform_points(here, points)[:, 2] < transform_points(here, moved)[2] - RADIUS - 0.02
    assert not before.any()  # nothing is left in front of where it is now


def test_without_depth_there_is_nothing():
    frame = look({}, BALL)._replace(depth=np.full((DEPTH.height, DEPTH.width), np.nan, np.float32))
    assert BodyCloud(VOXEL, 60.0, 0.02).update(frame, 0.0).shape == (0, 3)
