"""The fit of a disc: exact on planes, nearly so on curved skin, blind to outliers, honest about noise."""

import numpy as np
import pytest
from bathbot_localize.surface.registration import picture_rays
from bathbot_localize.surface.surface_fit import DegenerateSurfaceError, fit_surface
from hypothesis import given, settings
from hypothesis import strategies as st
from localize_scene import COLOUR, FB, cylinder, plane, sphere

PIXEL = (210.0, 118.0)
RAYS = picture_rays(COLOUR)
DIRECTION = COLOUR.directions(np.array(PIXEL))


def disc(shape, radius, rng=None, sigma_px=0.0):
    """Points of a shape in the camera's frame on the pixels of a disc, with disparity noise."""
    u, v = np.meshgrid(np.arange(COLOUR.width), np.arange(COLOUR.height))
    rays = RAYS[np.hypot(u - PIXEL[0], v - PIXEL[1]) <= radius]
    depth = shape(np.zeros(3), rays)
    if rng is not None:
        depth = FB / (FB / depth + rng.normal(0.0, sigma_px, depth.shape))
    return rays * depth[:, None]


def normal_at(shape):
    """Unit normal towards the camera on the target's ray, by finite differences."""
    corners = [COLOUR.directions(np.add(PIXEL, step)) for step in ((0.0, 0.0), (1e-3, 0.0), (0.0, 1e-3))]
    a, b, c = (ray * shape(np.zeros(3), ray) for ray in corners)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    return normal if normal @ a < 0.0 else -normal


def angle_deg(first, second):
    return np.degrees(np.arccos(np.clip(first @ second, -1.0, 1.0)))


@settings(max_examples=40, deadline=None)
@given(
    x=st.floats(-1.0, 1.0),
    y=st.floats(-1.0, 1.0),
    distance=st.floats(0.4, 1.2),
    radius=st.sampled_from([3, 6, 14]),
)
def test_planes_are_exact(x, y, distance, radius):
    shape = plane(DIRECTION * distance, (x, y, -1.0))
    fit = fit_surface(disc(shape, radius), DIRECTION)
    point, normal = fit.point_and_normal()
    np.testing.assert_allclose(point, DIRECTION * distance, atol=1e-9)
    assert angle_deg(normal, normal_at(shape)) < 1e-4
    assert fit.inliers == 1.0


@pytest.mark.parametrize(
    ("shape", "millimetres", "degrees"),
    [
        pytest.param(sphere((0.02, 0.01, 0.85), 0.15), 0.15, 0.4, id="belly"),
        pytest.param(cylinder((0.0, 0.01, 0.80), (0.2, 1.0, 0.1), 0.12), 0.15, 0.4, id="thigh"),
        pytest.param(cylinder((0.01, 0.0, 0.70), (1.0, 0.3, 0.1), 0.045), 0.4, 1.5, id="forearm"),
    ],
)
def test_curved_skin_without_noise(shape, millimetres, degrees):
    point, normal = fit_surface(disc(shape, 8.0), DIRECTION).point_and_normal()
    true_point = DIRECTION * shape(np.zeros(3), DIRECTION)
    assert 1e3 * np.linalg.norm(point - true_point) < millimetres
    assert angle_deg(normal, normal_at(shape)) < degrees


def test_the_normal_looks_at_the_camera():
    for tilt in np.linspace(-0.8, 0.8, 9):
        point, normal = fit_surface(
            disc(plane((0, 0, 0.7), (tilt, 0.3, -1.0)), 6.0), DIRECTION
        ).point_and_normal()
        assert normal @ point < 0.0
        assert np.linalg.norm(normal) == pytest.approx(1.0)


def test_a_quarter_of_outliers_does_no_harm():
    rng = np.random.default_rng(0)
    shape = sphere((0.02, 0.01, 0.85), 0.15)
    points = disc(shape, 12.0, rng, 0.07)
    wild = rng.random(len(points)) < 0.25
    points[wild] *= rng.uniform(1.05, 1.4, (wild.sum(), 1))
    fit = fit_surface(points, DIRECTION)
    point, normal = fit.point_and_normal()
    assert np.linalg.norm(point - DIRECTION * shape(np.zeros(3), DIRECTION)) < 0.001
    assert angle_deg(normal, normal_at(shape)) < 2.0
    assert 0.7 < fit.inliers < 0.85


def test_points_of_an_unknown_depth_are_left_out():
    points = disc(plane((0, 0, 0.7), (0.1, 0.3, -1.0)), 8.0)
    holes = points.copy()
    holes[::3] = np.nan
    np.testing.assert_allclose(
        fit_surface(holes, DIRECTION).parameters, fit_surface(points, DIRECTION).parameters, atol=1e-9
    )


def test_the_covariance_is_what_a_monte_carlo_run_shows():
    rng = np.random.default_rng(1)
    shape = sphere((0.02, 0.01, 0.85), 0.15)
    fits = [fit_surface(disc(shape, 10.0, rng, 0.07), DIRECTION) for _ in range(300)]
    spread = np.cov(np.stack([fit.parameters for fit in fits]).T)
    told = np.mean([fit.covariance for fit in fits], axis=0)
    assert np.diag(told) == pytest.approx(np.diag(spread), rel=0.35)
    scatter = np.median([fit.scale for fit in fits])
    depth = shape(np.zeros(3), DIRECTION)
    assert scatter == pytest.approx(0.07 * depth**2 / FB, rel=0.1)


def test_correlated_noise_widens_the_covariance():
    points = disc(plane((0, 0, 0.7), (0.1, 0.3, -1.0)), 8.0, np.random.default_rng(2), 0.07)
    white, blurred = fit_surface(points, DIRECTION), fit_surface(points, DIRECTION, correlation=9.0)
    np.testing.assert_allclose(blurred.covariance, 9.0 * white.covariance)
    np.testing.assert_allclose(blurred.parameters, white.parameters)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.full((50, 3), np.nan), "0 points"),
        (np.zeros((50, 3)), "0 points"),
        (np.tile([0.0, 0.0, 0.7], (50, 1)), "one"),
        (np.outer(np.linspace(0.6, 0.8, 20), [0.1, 0.2, 0.0]) + np.array([0.0, 0.0, 0.7]), "line"),
    ],
)
def test_points_that_make_no_surface_are_refused(points, message):
    with pytest.raises(DegenerateSurfaceError, match=message):
        fit_surface(points, DIRECTION)


@pytest.mark.parametrize(
    "shape",
    [
        pytest.param(plane((0.0, 0.0, 0.75), (0.3, -0.2, -1.0)), id="plane"),
        pytest.param(sphere((0.02, 0.01, 0.85), 0.15), id="sphere"),
        pytest.param(cylinder((0.0, 0.01, 0.80), (0.2, 1.0, 0.1), 0.12), id="cylinder"),
    ],
)
def test_normals_and_points_under_noise(shape):
    rng = np.random.default_rng(4)
    expected_normal, expected_point = normal_at(shape), DIRECTION * shape(np.zeros(3), DIRECTION)
    found = [fit_surface(disc(shape, 10.0, rng, 0.07), DIRECTION).point_and_normal() for _ in range(40)]
    turns = [angle_deg(normal, expected_normal) for _, normal in found]
    misses = [np.linalg.norm(point - expected_point) for point, _ in found]
    assert np.mean(turns) < 1.0
    assert np.max(turns) < 2.5
    assert np.mean(misses) < 0.0004
