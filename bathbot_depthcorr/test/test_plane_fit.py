import numpy as np
import pytest
from bathbot_depthcorr.geometry.plane import DegeneratePlaneError, Plane, fit_plane, plane_from_inverse_form
from bathbot_depthcorr.geometry.rigid import transform_from, transform_points
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

tilts = st.floats(-0.9, 0.9)


def cloud(tilt_x, tilt_y, distance, seed=0, noise=0.0, count=200):
    rng = np.random.default_rng(seed)
    normal = Rotation.from_euler("xy", (tilt_x, tilt_y)).apply((0.0, 0.0, -1.0))
    plane = Plane(normal, float(normal[2] * distance))
    rays = np.column_stack([rng.uniform(-0.4, 0.4, (count, 2)), np.ones(count)])
    return plane, rays * plane.depth_along(rays)[:, None] + rng.normal(0.0, noise, (count, 3))


@settings(max_examples=30)
@given(tilt_x=tilts, tilt_y=tilts, distance=st.floats(0.3, 3.0))
def test_exact_points_give_their_plane_facing_the_camera(tilt_x, tilt_y, distance):
    plane, points = cloud(tilt_x, tilt_y, distance)
    found = fit_plane(points)
    assert found.offset <= 0.0
    assert_allclose(found.normal, plane.normal, atol=1e-7)
    assert_allclose(found.offset, plane.offset, atol=1e-7)


@settings(max_examples=30)
@given(
    tilt=tilts,
    turn=st.tuples(tilts, tilts, tilts),
    shift=st.tuples(tilts, tilts, tilts),
    seed=st.integers(0, 99),
)
def test_the_fit_moves_with_the_points(tilt, turn, shift, seed):
    """Rigid motion and fit commute, up to the side the normal points to."""
    _, points = cloud(tilt, 0.2, 0.8, seed, noise=0.002)
    transform = transform_from(Rotation.from_rotvec(turn).as_matrix(), shift)
    moved = fit_plane(transform_points(transform, points))
    expected = fit_plane(points).transformed(transform)
    side = np.sign(moved.normal @ expected.normal)
    assert_allclose(moved.normal * side, expected.normal, atol=1e-8)
    assert_allclose(moved.offset * side, expected.offset, atol=1e-8)


@given(tilt_x=tilts, tilt_y=tilts, distance=st.floats(0.3, 3.0))
def test_inverse_form_round_trip(tilt_x, tilt_y, distance):
    plane, points = cloud(tilt_x, tilt_y, distance, count=5)
    points = points[np.isfinite(points).all(axis=1)]  # on a steep wall a ray may pass it by
    assert_allclose(points @ plane.inverse_form, 1.0)
    again = plane_from_inverse_form(plane.inverse_form)
    assert_allclose(again.normal, plane.normal, atol=1e-12)
    assert_allclose(again.offset, plane.offset)


def test_flying_pixels_do_no_harm_to_the_robust_fit():
    plane, points = cloud(0.2, -0.1, 0.75, noise=0.0005, count=1000)
    points[:250, 2] += np.random.default_rng(1).uniform(0.01, 0.5, 250)
    found = fit_plane(points, robust=True)
    assert np.degrees(np.arccos(found.normal @ plane.normal)) < 0.05
    assert abs(found.offset - plane.offset) < 2e-4
    assert abs(fit_plane(points).offset - plane.offset) > 0.01


def test_weights_decide_between_two_planes():
    near, far = np.mgrid[0:5, 0:5].reshape(2, -1).T * 0.1, np.mgrid[0:5, 0:5].reshape(2, -1).T * 0.1
    points = np.concatenate(
        [np.column_stack([near, np.full(25, 1.0)]), np.column_stack([far, np.full(25, 2.0)])]
    )
    assert_allclose(fit_plane(points, np.repeat([1.0, 0.0], 25)).offset, -1.0)


def test_points_without_depth_are_left_out():
    _, points = cloud(0.1, 0.1, 0.7)
    holed = np.concatenate([points, np.full((50, 3), np.nan)])
    assert_allclose(fit_plane(holed).normal, fit_plane(points).normal)


def test_a_ray_along_the_plane_or_behind_it_has_no_depth():
    plane = Plane(np.array([0.0, 0.0, -1.0]), -1.0)
    assert np.isnan(plane.depth_along((0.0, 1.0, 0.0)))
    assert np.isnan(Plane(np.array([0.0, 0.0, -1.0]), 1.0).depth_along((0.0, 0.0, 1.0)))
    assert_allclose(plane.depth_along((0.3, 0.2, 1.0)), 1.0)


@pytest.mark.parametrize(
    "points",
    [np.zeros((0, 3)), np.eye(3)[:2], np.outer(np.arange(9.0), (1, 2, 3)), np.full((9, 3), np.nan)],
    ids=["none", "two", "on a line", "all NaN"],
)
def test_points_that_determine_no_plane_are_refused_with_evidence(points):
    with pytest.raises(
        DegeneratePlaneError, match=r"cannot fit a plane to \d+ points with second spread"
    ) as caught:
        fit_plane(points)
    assert caught.value.count <= 9
