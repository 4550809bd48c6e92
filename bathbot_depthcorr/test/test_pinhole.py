import numpy as np
import pytest
from bathbot_depthcorr.geometry.pinhole import InvalidIntrinsicsError, Pinhole
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

PLAIN = Pinhole(1280, 720, 640.0, 638.0, 640.0, 360.0)
LENS = Pinhole(1280, 720, 632.4, 632.0, 639.8, 363.3, (-0.0565, 0.0688, -0.00072, -0.00002, -0.0224))
pixels = st.tuples(st.floats(0.0, 1279.0), st.floats(0.0, 719.0))


@pytest.mark.parametrize("camera", [PLAIN, LENS], ids=["rectified", "with lens"])
@given(pixel=pixels, depth=st.floats(0.2, 5.0))
def test_projection_undoes_deprojection(camera, pixel, depth):
    point = camera.deproject(pixel, depth)
    assert_allclose(point[2], depth)
    assert_allclose(camera.project(point), pixel, atol=1e-5)


@given(pixel=pixels, depth=st.floats(0.2, 5.0), factor=st.sampled_from([0.5, 848 / 1280, 2.0]))
def test_a_scaled_camera_sees_the_same_ray(pixel, depth, factor):
    small = PLAIN.scaled(round(1280 * factor), round(720 * factor))
    seen = small.project(PLAIN.deproject(pixel, depth))
    ratio = np.array([small.width / 1280, small.height / 720])
    assert_allclose(seen, (np.array(pixel) + 0.5) * ratio - 0.5, atol=1e-6)


@pytest.mark.parametrize(
    ("pixel", "point"),
    [
        pytest.param((640.0, 360.0), (0.0, 0.0, 0.8), id="optical axis"),
        pytest.param((640.0, 41.0), (0.0, -0.4, 0.8), id="up is minus y"),
        pytest.param((1280.0, 360.0), (0.8, 0.0, 0.8), id="right is plus x"),
    ],
)
def test_deprojection_by_hand(pixel, point):
    assert_allclose(PLAIN.deproject(pixel, 0.8), point, atol=1e-12)


def test_no_depth_gives_no_point_and_behind_gives_no_pixel():
    assert np.isnan(PLAIN.deproject((10.0, 10.0), np.nan)).all()
    assert np.isnan(PLAIN.project((0.1, 0.1, -1.0))).all()


def test_leading_axes_broadcast():
    grid = PLAIN.pixel_grid()[::90, ::160]
    assert PLAIN.deproject(grid, np.ones(grid.shape[:2])).shape == (*grid.shape[:2], 3)


@pytest.mark.parametrize("focal", [0.0, -1.0, np.nan, np.inf])
def test_numbers_that_describe_no_camera_are_refused(focal):
    with pytest.raises(InvalidIntrinsicsError, match=r"describe no camera; is camera_info published"):
        Pinhole(640, 480, focal, 500.0, 320.0, 240.0)
