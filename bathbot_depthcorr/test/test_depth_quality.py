import numpy as np
import pytest
from bathbot_depthcorr.plane import Plane
from bathbot_depthcorr.quality import NoDepthError, fill_rate, plane_rmse, z_accuracy
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
