"""Depth registered into the colour picture: exact on planes, the nearest surface wins, holes stay holes."""

import cv2
import numpy as np
import pytest
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import rotate, transform_points
from bathbot_localize.errors import LocalizeError
from bathbot_localize.surface.registration import OutsideImageError, clip_box, picture_rays, register
from hypothesis import given, settings
from hypothesis import strategies as st
from localize_scene import COLOUR, DEPTH, T_BASE_COLOUR, T_COLOUR_DEPTH, plane, render, sphere

BOX = (120.0, 70.0, 300.0, 190.0)


def registered(depth, box=BOX, stride=1):
    return register(depth, DEPTH, T_COLOUR_DEPTH, COLOUR, box, stride)


def points_on_rays(patch):
    """Rays of a patch's pixels (x/z, y/z, 1) in the colour camera."""
    return picture_rays(COLOUR)[np.ix_(patch.v.astype(int), patch.u.astype(int))]


def eroded(mask):
    """A mask without its outermost three pixels."""
    return cv2.erode(mask.astype(np.uint8), np.ones((7, 7), np.uint8)).astype(bool)


@settings(max_examples=25, deadline=None)
@given(
    tilt=st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6)),
    distance=st.floats(0.5, 1.2),
    stride=st.integers(1, 5),
)
def test_a_plane_is_registered_exactly(tilt, distance, stride):
    normal = np.array([tilt[0], tilt[1], -1.0])
    normal /= np.linalg.norm(normal)
    rays = picture_rays(DEPTH)
    depth = (-distance / (rays @ normal)).astype(np.float32)
    points = registered(depth, stride=stride).points
    normal_colour = rotate(T_COLOUR_DEPTH, normal)
    offset = -distance + normal_colour @ T_COLOUR_DEPTH[:3, 3]
    assert np.isfinite(points).all()
    assert np.abs(points @ normal_colour - offset).max() < 2e-6


def test_points_lie_on_the_rays_of_their_pixels():
    patch = registered(render(plane((0.6, 0.0, 0.2), (-1.0, 0.2, 0.1))), stride=3)
    u, v = np.meshgrid(patch.u, patch.v)
    np.testing.assert_allclose(COLOUR.project(patch.points), np.stack([u, v], axis=-1), atol=1e-6)


def test_a_sphere_is_registered_to_a_tenth_of_a_millimetre():
    depth = render(sphere((0.55, 0.0, 0.25), 0.15))
    points = transform_points(T_BASE_COLOUR, registered(depth).points)
    off = np.abs(np.linalg.norm(points - (0.55, 0.0, 0.25), axis=-1) - 0.15)
    inner = np.isfinite(off)
    assert inner.sum() > 2000
    assert np.nanpercentile(off, 90) < 1e-4


def test_the_nearer_surface_wins():
    ball, wall = sphere((0.55, 0.0, 0.25), 0.12), plane((0.9, 0.0, 0.0), (-1.0, 0.0, 0.0))
    points = transform_points(T_BASE_COLOUR, registered(render(ball, wall)).points)
    distance = np.linalg.norm(points - (0.55, 0.0, 0.25), axis=-1)
    known = np.isfinite(distance)
    on_ball, on_wall = np.abs(distance - 0.12) < 1e-3, np.abs(points[..., 0] - 0.9) < 1e-3
    assert (on_ball | on_wall)[known].mean() > 0.99  # nothing is drawn across the edge
    assert on_ball.sum() > 1000
    assert on_wall.sum() > 1000
    # Where the ray of a pixel meets the ball, the wall behind it must not show through.
    rays = rotate(T_BASE_COLOUR, points_on_rays(registered(render(wall), BOX)))
    meets = np.isfinite(ball(T_BASE_COLOUR[:3, 3], rays))
    assert (on_wall & eroded(meets)).sum() == 0


def test_missing_depth_stays_missing():
    depth = render(plane((0.6, 0.0, 0.2), (-1.0, 0.2, 0.1)))
    depth[100:120, 200:230] = np.nan
    valid = registered(depth).valid
    assert 500 < (~valid).sum() < 800
    assert not registered(np.full_like(depth, np.nan)).valid.any()


def test_one_missing_pixel_makes_a_hole_of_about_two_pixels():
    depth = render(plane((0.6, 0.0, 0.2), (-1.0, 0.2, 0.1)))
    depth[110, 210] = np.nan
    assert 0 < (~registered(depth).valid).sum() <= 4


def test_zero_is_no_depth():
    assert not registered(np.zeros((DEPTH.height, DEPTH.width), np.float32)).valid.any()


@pytest.mark.parametrize(
    "box", [(-90.0, -40.0, -5.0, -2.0), (500.0, 10.0, 600.0, 40.0), (10.0, 10.0, 10.2, 10.2)]
)
def test_a_box_outside_the_picture_is_refused(box):
    with pytest.raises(OutsideImageError, match="outside"):
        registered(render(plane((0.6, 0.0, 0.2), (-1.0, 0.2, 0.1))), box)


def test_a_box_that_is_not_finite_is_refused():
    with pytest.raises(OutsideImageError, match="not finite"):
        clip_box((np.nan, 0.0, 10.0, 10.0), 100, 100)


def test_a_box_across_the_border_is_clipped():
    assert clip_box((-10.0, -10.0, 20.0, 500.0), 100, 80) == (0, 0, 20, 80)
    assert clip_box((0.0, 0.0, 100.0, 80.0), 100, 80) == (0, 0, 100, 80)


def test_depth_of_another_size_is_refused():
    with pytest.raises(LocalizeError, match="camera_info"):
        register(np.ones((10, 10), np.float32), DEPTH, T_COLOUR_DEPTH, COLOUR, BOX)


def test_the_same_camera_twice_changes_nothing():
    """With one camera in both places registration is the identity."""
    camera = Pinhole(64, 48, 50.0, 50.0, 31.5, 23.5)
    depth = np.random.default_rng(0).uniform(0.70, 0.72, (48, 64)).astype(np.float32)
    patch = register(depth, camera, np.eye(4), camera, (1.0, 1.0, 63.0, 47.0))
    np.testing.assert_allclose(patch.points[..., 2], depth[1:47, 1:63], rtol=1e-6)
