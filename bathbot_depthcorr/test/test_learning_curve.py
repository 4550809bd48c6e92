"""The learning curve: which views each fit sees, and what is measured on the held-out ones."""

import numpy as np
import pytest
from bathbot_depthcorr.calibration.guards import check_coverage
from bathbot_depthcorr.calibration.learning_curve import SIZES, LearningPoint, learning_curve, smooth_error
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Identity
from bathbot_depthcorr.views.views import CalibrationView
from depthcorr_wall import Sensor, wall, walls

SENSOR = Sensor(seed=5, width=424, height=240, least_depth=0.2)


def exact(plane, offset=0.0, noise=0.0):
    truth = SENSOR.truth(plane) + offset
    rng = np.random.default_rng(0)
    return CalibrationView((truth + noise * rng.normal(size=truth.shape)).astype(np.float32), plane)


@pytest.fixture
def unit():
    return CameraUnit(SENSOR.camera, SENSOR.T_colour_depth)


def test_each_fit_sees_views_from_the_nearest_to_the_farthest(unit):
    training = [exact(plane) for plane in walls(np.random.default_rng(1), 13)]
    seen, shares = [], []

    def fit(views, camera):
        seen.append(list(views))
        return Identity(camera)

    points = learning_curve(fit, training, training[:2], unit, lambda share, _: shares.append(share))
    assert [point.views for point in points] == [len(views) for views in seen] == [6, 9, 12]
    for views in seen:
        assert views[0] is training[0]
        assert views[-1] is training[-1]
        assert len({id(view) for view in views}) == len(views)
    assert shares == sorted(shares)


def test_few_views_give_no_curve(unit):
    training = [exact(plane) for plane in walls(np.random.default_rng(1), SIZES[0])]
    assert learning_curve(lambda *_: pytest.fail("fitted"), training, training, unit) == ()


def test_patches_measure_the_error_and_not_the_noise(unit):
    """An offset of 2 mm under noise of 5 mm; a pixel would err by more than 4 mm."""
    views = [exact(wall(0.8), 0.002, 0.005), exact(wall(1.0, 0.2), -0.002, 0.005)]
    assert smooth_error(Identity(unit), views) == pytest.approx(0.002, rel=0.02)
    assert LearningPoint(6, 0.1).views == 6


def test_coverage_is_warned_of_with_numbers(unit):
    views = [exact(plane) for plane in walls(np.random.default_rng(2), 12, near=0.5, far=1.0)]
    (warning,) = check_coverage(views, unit)
    assert "1.1-1.4 m 0 of 3, 1.4-2 m 0 of 2" in warning
    assert "0.6-0.75 m" not in warning
    for view in views:
        view.depth[:, 300:] = np.nan
    assert "upper right 0 of 5, lower right 0 of 5" in check_coverage(views, unit)[0]
