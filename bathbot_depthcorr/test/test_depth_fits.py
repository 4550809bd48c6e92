"""The fits on a simulated sensor: errors in millimetres, held against the truth."""

from dataclasses import replace

import numpy as np
import pytest
from bathbot_depthcorr.calibration.wall_extraction import only_wall
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.disparity_fit import fit_disparity_spline
from bathbot_depthcorr.models.two_imager_fit import fit_two_imager
from bathbot_depthcorr.models.two_stage_fit import fit_two_stage
from bathbot_depthcorr.views.views import true_depth
from depthcorr_wall import Sensor, blurred, wall, walls

FITS = {"disparity_spline": fit_disparity_spline, "two_stage": fit_two_stage, "two_imager": fit_two_imager}
LIMITS_MM = {"disparity_spline": 0.5, "two_imager": 0.5, "two_stage": 1.111}  # ours; the paper's figure
TESTS = [wall(z, *tilt) for z, tilt in ((0.62, (0.1, -0.2)), (0.75, (-0.25, 0.1)), (0.88, (0.05, 0.25)))]


@pytest.fixture(scope="module")
def calibrated():
    sensor = Sensor(seed=1, width=424, height=240, least_depth=0.2)
    rng = np.random.default_rng(1)
    views = [sensor.view(plane, rng, frames=2, plane_error=1e-4) for plane in walls(rng, 18)]
    return sensor, views, {name: fit(views, sensor.factory) for name, fit in FITS.items()}


def systematic_mm(sensor, correction, plane):
    """Error along the colour axis with noise off, the correction's own transform included."""
    clean = sensor.clean(sensor.truth(plane)).astype(np.float32)
    rays = sensor.camera.directions(sensor.camera.pixel_grid())
    transform = correction.T_colour_depth
    points = (rays * correction.apply(clean)[..., None]) @ transform[:3, :3].T + transform[:3, 3]
    error = 1e3 * (points[..., 2] - plane.depth_along(points / points[..., 2:]))
    seen = np.arange(sensor.width) >= sensor.factory.focal_baseline / sensor.truth(plane)
    return float(np.abs(error[seen]).mean())


def raw_mm(sensor, plane):
    truth = sensor.truth(plane)
    return 1e3 * float(np.abs(sensor.clean(truth) - truth).mean())


@pytest.mark.parametrize("name", sorted(FITS))
def test_systematic_error_falls_from_the_papers_range_to_a_fraction(calibrated, name):
    sensor, _, corrections = calibrated
    assert 14.0 < np.mean([raw_mm(sensor, plane) for plane in TESTS]) < 24.0
    errors = [systematic_mm(sensor, corrections[name], plane) for plane in TESTS]
    assert np.mean(errors) < LIMITS_MM[name]


def test_the_default_beats_the_paper(calibrated):
    sensor, _, corrections = calibrated
    ours, papers = (
        np.mean([systematic_mm(sensor, corrections[name], plane) for plane in TESTS])
        for name in ("disparity_spline", "two_stage")
    )
    assert ours < papers


def test_the_transform_is_recovered_better_than_the_factory_knew_it(calibrated):
    sensor, _, corrections = calibrated
    fitted = corrections["disparity_spline"].T_colour_depth
    for part in ((slice(3), slice(3)), (slice(3), 3)):
        truth, factory = sensor.T_colour_depth[part], sensor.factory.T_colour_depth[part]
        assert np.linalg.norm(fitted[part] - truth) < np.linalg.norm(factory - truth)


def test_sigma_tells_the_error_of_one_frame(calibrated):
    sensor, _, corrections = calibrated
    correction = corrections["disparity_spline"]
    rng = np.random.default_rng(5)
    ratios = []
    for plane in TESTS:
        truth = sensor.truth(plane)
        corrected = correction.apply(sensor.frame(truth, rng, blurred(rng, truth.shape, 3.0, sensor.frozen)))
        error = (corrected - truth)[np.isfinite(corrected)]
        expected = correction.sigma(corrected)[np.isfinite(corrected)]
        ratios.append(np.sqrt(np.mean(np.square(error / expected))))
    assert 0.8 < np.mean(ratios) < 1.3


@pytest.mark.parametrize("name", sorted(FITS))
def test_a_perfect_camera_stays_as_it_is(name):
    sensor = Sensor(
        width=424, height=240, scale=0.0, shift=0.0, field_size=0.0, ripple=0.0, frozen=0.0, temporal=0.0,
        quantum=0.0,
    )  # fmt: skip
    rng = np.random.default_rng(0)
    correction = FITS[name]([sensor.view(plane, rng, frames=1) for plane in walls(rng, 12)], sensor.factory)
    for plane in TESTS:
        truth = sensor.truth(plane).astype(np.float32)
        assert np.nanmean(np.abs(correction.apply(truth) - truth)) < 0.05e-3
    np.testing.assert_allclose(correction.T_colour_depth, sensor.T_colour_depth, atol=1e-5)


@pytest.mark.parametrize("name", sorted(FITS))
def test_a_bathtub_before_the_wall_does_no_harm(calibrated, name):
    """A fifth of each picture shows something nearer than the wall."""
    sensor, views, _ = calibrated
    spoilt = []
    for view in views:
        depth = view.depth.copy()
        depth[-60:, 100:300] *= 0.85
        found = only_wall(replace(view, depth=depth), sensor.factory)
        assert np.isnan(found.depth[-60:, 100:300]).mean() > 0.98
        assert np.isfinite(found.depth[:170]).sum() > 0.99 * np.isfinite(depth[:170]).sum()
        spoilt.append(found)
    correction = FITS[name](spoilt, sensor.factory)
    assert np.mean([systematic_mm(sensor, correction, plane) for plane in TESTS]) < 1.2 * LIMITS_MM[name]


def test_true_depth_is_the_wall(calibrated):
    sensor, views, _ = calibrated
    unit = CameraUnit(sensor.camera, sensor.T_colour_depth)
    np.testing.assert_allclose(true_depth(views[3], unit), sensor.truth(views[3].plane), rtol=1e-9)
