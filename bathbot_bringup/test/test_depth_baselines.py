"""The corrections of others: each undoes exactly an error of its own form, and none does harm."""

from typing import NamedTuple

import numpy as np
import pytest
from bathbot_bringup.evaluation.depth.methods.clams import PUBLISHED_BIN, Clams, fit_clams
from bathbot_bringup.evaluation.depth.methods.herrera import Herrera
from bathbot_bringup.evaluation.depth.methods.table import all_methods
from bathbot_bringup.evaluation.depth.methods.tare import Tare
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import Plane
from bathbot_depthcorr.geometry.rigid import inverse, rotation_angle, transform_from
from bathbot_depthcorr.views.views import CalibrationView
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

WIDTH, HEIGHT = 424, 240
CAMERA = Pinhole(WIDTH, HEIGHT, 212.5, 212.5, 212.1, 121.2)
TRUE = transform_from(Rotation.from_rotvec((0.002, -0.001, 0.001)).as_matrix(), (-0.059, 0.0003, 0.0))
OFF = transform_from(Rotation.from_rotvec(np.deg2rad((0.08, -0.1, 0.05))).as_matrix(), (5e-4, -4e-4, 6e-4))
X, Y = np.meshgrid(np.linspace(-1.0, 1.0, WIDTH), np.linspace(-1.0, 1.0, HEIGHT))
FOCAL_BASELINE = CameraUnit(CAMERA).focal_baseline
BASELINES = ["none", "tare", "global_quadratic", "clams", "herrera", "basso"]


def wall(distance, tilt_x=0.0, tilt_y=0.0):
    normal = Rotation.from_euler("xy", (tilt_x, tilt_y)).apply((0.0, 0.0, -1.0))
    return Plane(normal, float(normal[2] * distance))


def walls(count):
    rng = np.random.default_rng(7)
    return [wall(z, *rng.uniform(-0.35, 0.35, 2)) for z in 1.0 / np.linspace(1.0 / 0.5, 1.0 / 1.8, count)]


def inverted(formula):
    """Raw depth of true depth, for a sensor that `formula` (raw -> true) puts right."""

    def raw(truth):
        depth = truth
        for _ in range(14):
            depth = depth + 0.8 * (truth - formula(depth))
        return depth

    return raw


def tare_sensor(depth):
    return FOCAL_BASELINE / (FOCAL_BASELINE / depth + 0.4)


def quadratic_sensor(depth):
    return 0.004 + 0.985 * depth - 0.012 * depth**2


def clams_sensor(depth):
    return depth * (0.985 + 0.004 * X - 0.003 * Y)


def herrera_sensor(depth):
    disparity = FOCAL_BASELINE / depth
    distortion = (0.2 * np.sin(2.0 * X) + 0.1 * X * Y) * np.exp(-0.02 * (disparity - 20.0))
    return FOCAL_BASELINE / (1.01 * (disparity + distortion) + 0.3)


def basso_sensor(depth):
    """Flat in the middle, where the method takes its plane; beyond, a quadratic per pixel."""
    radius = np.hypot(X * WIDTH / HEIGHT, Y)
    bend = np.maximum(radius - 1.0, 0.0) ** 2 * np.cos(3.0 * Y)
    return 0.988 * (depth + bend * (0.002 - 0.004 * depth - 0.003 * depth**2))


class Case(NamedTuple):
    """A sensor of a method's own form, the factory's error, and what may be left [m]."""

    formula: object
    off: np.ndarray
    tolerance: float


OWN = {
    "tare": Case(tare_sensor, np.eye(4), 1e-6),
    "global_quadratic": Case(quadratic_sensor, OFF, 2e-5),
    "clams": Case(clams_sensor, np.eye(4), 1.5e-4),  # its cells are steps
    "herrera": Case(herrera_sensor, OFF, 5e-5),
    "basso": Case(basso_sensor, OFF, 1e-4),
}


def truth_of(plane, transform=TRUE):
    return plane.transformed(inverse(transform)).depth_along(CAMERA.directions(CAMERA.pixel_grid()))


def exact_views(raw, count=18):
    views = []
    for plane in walls(count):
        depth = raw(truth_of(plane)).astype(np.float32)
        depth[:, :20] = np.nan  # the blind band
        views.append(CalibrationView(depth, plane, frames=100))
    return views


@pytest.fixture(scope="module")
def own():
    """Each method fitted to a sensor of its own form."""
    return {
        name: all_methods()[name].fit(
            exact_views(inverted(case.formula)), CameraUnit(CAMERA, case.off @ TRUE)
        )
        for name, case in OWN.items()
    }


@pytest.mark.parametrize("name", sorted(OWN))
def test_an_error_of_its_own_form_is_undone(own, name):
    raw = inverted(OWN[name].formula)
    for plane in (wall(0.65, 0.1, -0.2), wall(0.8, -0.2, 0.1), wall(1.3)):
        corrected = own[name].apply(raw(truth_of(plane)).astype(np.float32))
        error = corrected - truth_of(plane, own[name].T_colour_depth)
        assert np.abs(error[:, 24:]).mean() < OWN[name].tolerance
        assert np.abs(error[:, 24:]).max() < 20.0 * OWN[name].tolerance


@pytest.mark.parametrize("name", ["global_quadratic", "herrera", "basso"])
def test_the_transform_stays_within_the_prior_and_comes_nearer_to_the_truth(own, name):
    fitted, factory = own[name].T_colour_depth, OFF @ TRUE
    away = [rotation_angle(T[:3, :3] @ TRUE[:3, :3].T) for T in (fitted, factory)]
    assert away[0] < 0.3 * away[1]
    assert np.linalg.norm(fitted[:3, 3] - TRUE[:3, 3]) < np.linalg.norm(factory[:3, 3] - TRUE[:3, 3])
    assert rotation_angle(fitted[:3, :3] @ factory[:3, :3].T) < np.deg2rad(0.3)
    assert np.linalg.norm(fitted[:3, 3] - factory[:3, 3]) < 2e-3


@pytest.mark.parametrize("name", ["none", "tare", "clams"])
def test_who_fits_no_transform_keeps_the_factorys(name):
    unit = CameraUnit(CAMERA, OFF @ TRUE)
    correction = all_methods()[name].fit(exact_views(inverted(tare_sensor), 4), unit)
    assert_allclose(correction.T_colour_depth, OFF @ TRUE, atol=1e-15)


@pytest.mark.parametrize("name", BASELINES)
def test_a_perfect_sensor_stays_as_it_is(name):
    correction = all_methods()[name].fit(exact_views(lambda truth: truth, 12), CameraUnit(CAMERA, TRUE))
    for plane in (wall(0.62, 0.1), wall(0.88, -0.1, 0.2), wall(1.5)):
        truth = truth_of(plane).astype(np.float32)
        assert_allclose(correction.apply(truth), truth, atol=1e-5)
    assert_allclose(correction.T_colour_depth, TRUE, atol=1e-5)


@pytest.mark.parametrize("name", sorted(OWN))
def test_depth_is_never_invented_and_always_float32(own, name):
    depth = np.full((HEIGHT, WIDTH), 0.8, dtype=np.float32)
    depth[50:60, 200:220] = np.nan
    before = depth.copy()
    corrected = own[name].apply(depth)
    assert corrected.dtype == np.float32
    assert np.array_equal(np.isnan(corrected), np.isnan(depth))
    assert np.array_equal(depth, before, equal_nan=True)
    nowhere = own[name].apply(np.full((HEIGHT, WIDTH), np.nan, dtype=np.float32))
    assert np.isnan(nowhere).all()


@pytest.mark.parametrize("name", ["tare", "global_quadratic", "herrera", "basso"])
def test_a_few_flying_pixels_do_no_harm(own, name):
    raw, rng = inverted(OWN[name].formula), np.random.default_rng(3)
    views = exact_views(raw)
    for view in views:
        rows, columns = rng.integers(0, HEIGHT - 16, 8), rng.integers(20, WIDTH - 16, 8)
        for row, column in zip(rows, columns, strict=True):
            view.depth[row : row + 16, column : column + 16] *= 1.3
    correction = all_methods()[name].fit(views, CameraUnit(CAMERA, OWN[name].off @ TRUE))
    depth = raw(truth_of(wall(0.8, 0.1, 0.1))).astype(np.float32)
    assert np.abs(correction.apply(depth) - own[name].apply(depth))[:, 24:].mean() < 2e-4


def test_tare_moves_disparity_by_its_offset():
    depth = np.array([[0.5, 1.0, 2.0]], dtype=np.float32)
    assert_allclose(Tare(np.eye(4), 0.02).apply(depth), [[0.5 / 1.01, 1.0 / 1.02, 2.0 / 1.04]], rtol=1e-6)


def test_tare_takes_the_nearest_view_when_none_stands_at_its_distance():
    views = [
        CalibrationView(inverted(tare_sensor)(truth_of(wall(z))).astype(np.float32), wall(z))
        for z in (1.4, 1.8)
    ]
    fitted = all_methods()["tare"].fit(views, CameraUnit(CAMERA, TRUE))
    assert fitted.offset == pytest.approx(0.4 / FOCAL_BASELINE, rel=1e-3)


def test_clams_is_linear_between_bins_with_samples_only():
    factors = np.array([1.1, 0.9, 1.3], dtype=np.float32).reshape(3, 1, 1)
    samples = np.array([50, 60, 49]).reshape(3, 1, 1)
    clams = Clams(np.eye(4), 0.5, factors, samples)
    depth = np.array([[0.25, 0.4, 0.5, 0.75, 0.9, 1.2, 7.0, np.nan]], dtype=np.float32)
    expected = [1.1, 1.04, 1.0, 0.9, 0.9, 1.3, 1.3, np.nan]
    assert_allclose(clams.apply(depth), depth * np.array([expected], dtype=np.float32), rtol=1e-6)


def test_clams_of_the_published_bins_is_coarser():
    views, unit = exact_views(inverted(tare_sensor)), CameraUnit(CAMERA, TRUE)
    truth = truth_of(wall(0.8))
    raw = inverted(tare_sensor)(truth).astype(np.float32)
    fine, coarse = (
        np.abs(fit_clams(views, unit, width).apply(raw) - truth).mean() for width in (0.25, PUBLISHED_BIN)
    )
    assert fine < 0.5 * coarse


def test_clams_fills_holes_between_cells_but_not_beyond_all_views():
    views, unit = exact_views(inverted(clams_sensor)), CameraUnit(CAMERA, TRUE)
    for view in views[12:]:
        view.depth[:, : WIDTH // 2] = np.nan
    correction = all_methods()["clams"].fit(views, unit)
    assert_allclose(
        correction.apply(inverted(clams_sensor)(np.full_like(X, 1.3)).astype(np.float32))[:, 24:],
        1.3,
        atol=2e-3,
    )
    beyond = np.full((HEIGHT, WIDTH), 5.0, dtype=np.float32)
    assert_allclose(correction.apply(beyond), beyond)


def test_herrera_computed_by_hand():
    distortion = np.array([[0.5, 0.5]], dtype=np.float32)
    herrera = Herrera(np.eye(4), 20.0, distortion, (0.4, 0.02), (0.01, 0.06))
    undistorted = np.array([20.0, 10.0]) + 0.5 * np.exp([0.0, 0.2])
    corrected = herrera.apply(np.array([[1.0, 2.0]], dtype=np.float32))
    assert_allclose(corrected, [1.0 / (0.06 * undistorted + 0.01)], rtol=1e-6)
