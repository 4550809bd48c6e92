import numpy as np
import pytest
from bathbot_depthcorr.geometry.plane import Plane, fit_plane
from bathbot_depthcorr.geometry.quality import (
    NoDepthError,
    fill_rate,
    plane_rmse,
    temporal_noise,
    wall_accuracy,
    z_accuracy,
)
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.testing import assert_allclose

depths = hnp.arrays(float, st.integers(1, 40), elements=st.floats(0.1, 5.0))


@given(depth=depths, truth=st.floats(0.1, 5.0))
def test_signed_never_exceeds_absolute(depth, truth):
    """The paper's prose and its Eq. (3) agree only where all errors have one sign."""
    accuracy = z_accuracy(depth, truth)
    assert abs(accuracy.signed) <= accuracy.absolute + 1e-12
    assert accuracy.absolute <= np.abs(depth - truth).max() + 1e-12


def test_eq_3_by_hand():
    accuracy = z_accuracy([0.99, 1.03, np.nan, 1.0], 1.0)
    assert_allclose(accuracy.signed, 0.02 / 3)
    assert_allclose(accuracy.absolute, 0.04 / 3)


def test_eq_4_by_hand():
    points = np.array([(0.0, 0.0, 1.001), (1.0, 0.0, 0.999), (np.nan, 0.0, 1.0)])
    assert_allclose(plane_rmse(points, Plane(np.array([0.0, 0.0, -1.0]), -1.0)), 0.001)


def test_the_own_plane_hides_an_offset_that_the_true_plane_shows():
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-1, 1, (500, 2)), 1.02 + rng.normal(0.0, 0.001, 500)])
    assert_allclose(plane_rmse(points), 0.001, rtol=0.1)
    assert_allclose(plane_rmse(points, Plane(np.array([0.0, 0.0, -1.0]), -1.0)), 0.02, rtol=0.01)


def test_fill_rate_and_no_depth():
    assert fill_rate([[1.0, np.nan], [np.nan, np.nan]]) == 0.25
    with pytest.raises(NoDepthError, match="fill rate 0"):
        z_accuracy([np.nan], 1.0)


def wall_points(distance, spread=0.0, seed=0):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(-0.4, 0.4, (801, 2)), distance + rng.normal(0.0, spread, 801)])


@given(true=st.floats(0.4, 3.0), error=st.floats(-0.03, 0.03))
def test_wall_accuracy_is_the_signed_share_of_the_distance(true, error):
    points = wall_points(true * (1.0 + error))
    assert_allclose(wall_accuracy(points, fit_plane(points), true), error, atol=1e-9)


def test_wall_accuracy_by_hand():
    """Plane seen at 1.01 m, points 2, 3 and 9 mm behind it, true distance 1 m: 10 + 3 mm are 1.3 %."""
    points = [(0.0, 0.0, 1.012), (0.1, 0.0, 1.013), (0.0, 0.1, 1.019), (np.nan, 0.0, 1.0)]
    plane = Plane(np.array([0.0, 0.0, -1.0]), -1.01)
    assert_allclose(wall_accuracy(points, plane, 1.0), 0.013)


def test_a_few_flying_pixels_do_not_change_wall_accuracy():
    points = wall_points(0.757, spread=0.0005)
    points[:8, 2] = 2.0
    assert_allclose(wall_accuracy(points, fit_plane(points, robust=True), 0.75), 0.007 / 0.75, rtol=0.05)


def test_temporal_noise_is_that_of_one_frame():
    rng = np.random.default_rng(1)
    scene = rng.uniform(0.6, 0.9, (60, 80))
    one, two = (scene + rng.normal(0.0, 0.0007, scene.shape) for _ in range(2))
    one[:3] = np.nan
    one[5] += 0.2  # something moved
    assert_allclose(temporal_noise(one, two), 0.0007, rtol=0.05)
    assert np.isnan(temporal_noise(np.full(4, np.nan), np.ones(4)))
