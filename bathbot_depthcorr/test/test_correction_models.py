import numpy as np
import pytest
from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.geometry.bspline_surface import SplineGrid
from bathbot_depthcorr.geometry.camera_unit import CameraUnit, OtherCameraError
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.models.correction_model import DepthShapeError, Identity
from bathbot_depthcorr.models.disparity_spline import DisparitySpline
from bathbot_depthcorr.models.ripple import ripple_terms, tame
from bathbot_depthcorr.models.table import MODELS
from bathbot_depthcorr.models.two_imager import tame_map
from bathbot_depthcorr.models.two_stage import make_monotone
from correction_makers import CAMERA, MAKERS, UNIT, spline, two_imager, two_stage
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal


def made(name, seed=0):
    return MAKERS.get(name, lambda _: Identity(UNIT))(seed)


def surface(coefficients, camera=CAMERA):
    grid = SplineGrid(camera.width, camera.height, coefficients.shape[1], coefficients.shape[0])
    return grid.full(coefficients)


def frame(seed=0):
    depth = np.random.default_rng(seed).uniform(0.3, 3.0, (36, 64)).astype(np.float32)
    depth[::5] = np.nan
    return depth


@pytest.fixture(params=sorted(MODELS))
def name(request):
    return request.param


def test_no_depth_stays_no_depth_and_none_is_invented(name):
    corrected = made(name).apply(frame())
    assert corrected.dtype == np.float32
    assert_array_equal(np.isnan(corrected), np.isnan(frame()))


def test_zero_and_negative_count_as_no_depth_in_the_fitted_models():
    depth = np.zeros((36, 64), np.float32)
    depth[0] = -1.0
    for maker in MAKERS.values():
        assert np.isnan(maker().apply(depth)).all()


@pytest.mark.parametrize("seed", range(5))
def test_corrected_depth_rises_with_raw_depth(name, seed):
    """Even for wild maps: monotone over every millimetre that a D455 can report."""
    correction = made(name, seed)
    steps = np.stack([
        correction.apply(np.full((36, 64), z, np.float32))
        for z in np.arange(0.3, 4.0, 0.001, dtype=np.float32)
    ])  # fmt: skip
    assert (np.diff(steps, axis=0)[np.isfinite(np.diff(steps, axis=0))] > 0.0).all()


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 999), z=st.floats(0.3, 3.0))
def test_spline_is_the_written_formula(seed, z):
    correction = spline(seed)
    depth = np.full((36, 64), z, np.float32)
    scale, offset = surface(correction.scale), surface(correction.offset)
    disparity = UNIT.focal_baseline / depth.astype(float)
    expected = UNIT.focal_baseline / (
        disparity * (1 + scale) + offset + ripple_terms(disparity) @ correction.ripple
    )
    usable = (expected > 0.0) & (expected < 10.0)
    assert_allclose(correction.apply(depth)[usable], expected[usable], rtol=2e-4)


@settings(max_examples=30, deadline=None)
@given(
    kind=st.sampled_from(sorted(set(MODELS) - {"identity"})),
    seed=st.integers(0, 10_000),
    holes=st.floats(0.0, 1.0),
    none=st.sampled_from([0.0, np.nan, -1.0, -np.inf]),
)
def test_where_there_was_none_there_is_none(kind, seed, holes, none):
    depth = frame(seed)
    depth[np.random.default_rng(seed).random(depth.shape) < holes] = none
    assert np.isnan(made(kind, seed).apply(depth)[~(depth > 0.0)]).all()


@settings(max_examples=60, deadline=None)
@given(
    kind=st.sampled_from(sorted(set(MODELS) - {"identity"})),
    seed=st.integers(0, 10_000),
    depths=st.lists(st.floats(0.125, 8.0, width=32), min_size=2, max_size=8),
)
def test_farther_raw_depth_is_never_nearer_corrected(kind, seed, depths):
    """At every pixel, for any two depths however close: equal at worst, where float32 ends."""
    correction = made(kind, seed)
    steps = np.stack([correction.apply(np.full((36, 64), z, np.float32)) for z in sorted(depths)])
    rise = np.diff(steps, axis=0)
    assert (rise[np.isfinite(rise)] >= -2e-6 * np.nanmax(steps)).all()


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 999), z=st.floats(0.3, 3.0))
def test_the_right_imager_is_read_where_the_match_was_found(seed, z):
    correction = two_imager(seed)
    disparity = UNIT.focal_baseline / z
    matched = np.clip(np.arange(64) - disparity, 0, 62)
    right = np.array([np.interp(matched, np.arange(64), row) for row in surface(correction.right)])
    expected = UNIT.focal_baseline / (
        disparity * (1 + correction.scale) + surface(correction.left) - right
        + ripple_terms(disparity) @ correction.ripple
    )  # fmt: skip
    usable = (expected > 0.0) & (expected < 10.0)
    corrected = correction.apply(np.full((36, 64), z, np.float32))
    assert_allclose(corrected[usable], expected[usable], rtol=2e-4)


def test_maps_kept_at_few_rows_are_those_of_every_pixel():
    """The live correction interpolates between rows: at the camera's size that costs nothing."""
    camera = Pinhole(1280, 720, 641.5, 641.5, 640.0, 360.0)
    rng = np.random.default_rng(3)
    correction = DisparitySpline(
        CameraUnit(camera), rng.normal(0.0, 0.003, (4, 6)), rng.normal(0.0, 0.15, (11, 18)), np.zeros(4),
        0.07, np.zeros((3, 4, 4)),
    )  # fmt: skip
    disparity = CameraUnit(camera).focal_baseline / 0.75
    exact = disparity * (1.0 + surface(correction.scale, camera)) + surface(correction.offset, camera)
    corrected = correction.apply(np.full((720, 1280), 0.75, np.float32))
    assert np.abs(corrected - CameraUnit(camera).focal_baseline / exact).max() < 1e-5  # m


def test_out_is_written_and_given_back(name):
    correction, out = made(name), np.zeros((36, 64), np.float32)
    assert correction.apply(frame(), out) is out
    assert_array_equal(out, correction.apply(frame()))
    for wrong in (np.zeros((36, 63), np.float32), np.zeros((36, 64)), np.zeros((64, 36), np.float32).T):
        with pytest.raises(DepthShapeError, match="needed is contiguous float32"):
            correction.apply(frame(), wrong)


def test_zero_coefficients_are_exactly_the_identity():
    depth = frame()
    assert_array_equal(spline(strength=0.0).apply(depth), depth)
    assert_array_equal(two_imager(strength=0.0).apply(depth), depth)
    assert_array_equal(Identity(UNIT).apply(depth), depth)
    assert_allclose(two_stage(strength=0.0).apply(depth), depth, rtol=1e-6)


def test_the_input_is_left_alone(name):
    depth = frame()
    corrected = made(name).apply(depth)
    corrected[:] = 0.0
    assert_array_equal(depth, frame())


def test_sigma_grows_with_distance_and_follows_the_holes(name):
    correction = made(name)
    assert_array_equal(np.isnan(correction.sigma(frame())), np.isnan(frame()))
    near, far = (np.nanmean(correction.sigma(np.full((36, 64), z, np.float32))) for z in (0.5, 1.5))
    assert 0.0 < near < far


def test_sigma_by_hand():
    correction = DisparitySpline(
        UNIT, np.zeros((4, 4)), np.zeros((4, 4)), np.zeros(4), 0.06, np.zeros((3, 4, 4))
    )
    depth = np.full((36, 64), 0.75, np.float32)
    assert_allclose(correction.sigma(depth), 0.75**2 / (32.0 * 0.095) * 0.06, rtol=1e-5)


def test_save_and_load_give_the_same_correction(name, tmp_path):
    correction = made(name)
    correction.save(tmp_path / "unit.npz")
    again = load(tmp_path / "unit.npz")
    assert type(again) is type(correction)
    assert_array_equal(again.apply(frame()), correction.apply(frame()))
    assert_array_equal(again.sigma(frame()), correction.sigma(frame()))
    assert_array_equal(again.T_colour_depth, correction.T_colour_depth)
    assert (again.serial, again.temperature, again.depth_camera) == ("SN-1", 31.5, CAMERA)
    assert [path.name for path in tmp_path.iterdir()] == ["unit.npz"]


def test_tame_keeps_small_ripples_and_shrinks_wild_ones():
    assert_array_equal(tame([0.03, 0.01, 0.0, 0.001]), [0.03, 0.01, 0.0, 0.001])
    assert np.abs(tame([1.0, 1.0, 1.0, 1.0])).max() < 0.05


def test_tame_map_keeps_gentle_maps_and_flattens_steep_ones():
    gentle = np.random.default_rng(0).normal(0.0, 0.1, (11, 18))
    assert_array_equal(tame_map(gentle, 1280), gentle)
    steep = tame_map(1000.0 * gentle, 1280)
    assert np.abs(np.diff(surface(steep, Pinhole(1280, 720, 641.5, 641.5, 640.0, 360.0)), axis=1)).max() < 0.5


@given(st.tuples(st.floats(-1, 1), st.floats(-3, 3), st.floats(-3, 3)))
def test_make_monotone_rises_on_its_span(coefficients):
    _, slope, bend = make_monotone(coefficients, 0.4, 2.0)
    assert min(slope + 2 * bend * z for z in (0.4, 2.0)) >= 0.2 - 1e-9


@pytest.mark.parametrize(
    ("camera", "serial", "words"),
    [
        (Pinhole(128, 72, 64.0, 64.0, 64.0, 36.0), "", "64x36, camera sends 128x72"),
        (Pinhole(64, 36, 32.5, 32.0, 32.0, 18.0), "", "fx 32.00 px, camera has 32.50 px"),
        (Pinhole(64, 36, 32.0, 32.0, 32.0, 18.4), "", "cy 18.00 px, camera has 18.40 px"),
        (CAMERA, "SN-2", "camera SN-1, connected is SN-2"),
    ],
)
def test_another_camera_is_refused(camera, serial, words):
    UNIT.refuse_other(CAMERA, "SN-1")
    UNIT.refuse_other(CAMERA)
    with pytest.raises(OtherCameraError, match=words):
        UNIT.refuse_other(camera, serial)


def test_a_frame_of_another_size_is_refused(name):
    with pytest.raises(DepthShapeError, match=r"shape \(18, 32\), calibration is for \(36, 64\)"):
        made(name).apply(np.ones((18, 32), np.float32))
