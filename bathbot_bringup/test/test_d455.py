"""The D455's error model: laws, and the table the presets were chosen for."""

from dataclasses import replace

import numpy as np
import pytest
from bathbot_bringup.errors import SettingsError
from bathbot_bringup.sim.camera.d455 import D455, Air, soft_noise
from bathbot_bringup.sim.camera.d455_camera import camera_frames
from bathbot_bringup.sim.camera.d455_unit import PRESETS, Preset, find_preset, make_unit
from bathbot_bringup.sim.scene import T_LINK_OPTICAL
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

SIZE = (480, 848)
PAPER = D455(1, PRESETS["paper"], 848, 480)
PERFECT = D455(1, PRESETS["perfect"], 848, 480)


def wall(depth: float) -> np.ndarray:
    return np.full(SIZE, depth, dtype=np.float32)


def middle(frame: np.ndarray) -> np.ndarray:
    return frame[120:360, 212:636].astype(float)


@settings(max_examples=10, deadline=None)
@given(near=st.floats(0.3, 2.0), slope=st.floats(-0.3, 0.3))
def test_a_perfect_camera_only_rounds_to_millimetres(near, slope):
    depth = (near + slope * np.linspace(0.0, 1.0, SIZE[1], dtype=np.float32)) * np.ones(SIZE, np.float32)
    measured = PERFECT.measure(depth, np.random.default_rng(0))
    assert np.abs(measured * 1e-3 - depth).max() <= 0.5e-3 + 1e-6


@pytest.mark.parametrize(
    ("preset", "table_mm"),
    [
        pytest.param("paper", {0.6: 12.5, 0.7: 15.9, 0.8: 19.6, 0.9: 24.3, 1.4: 50.0, 2.0: 93.0}, id="paper"),
        pytest.param("yaw", {0.6: 11.0, 0.7: 14.8, 0.8: 19.6, 0.9: 26.3, 2.0: 136.0}, id="yaw"),
    ],
)
def test_presets_give_the_paper_s_range(preset, table_mm):
    plain = Preset(
        scale=PRESETS[preset].scale, offset=PRESETS[preset].offset, tilt=0.0, radial=0.0, smooth=0.0
    )
    sensor = D455(1, plain, 848, 480)
    for depth, expected in table_mm.items():
        measured = middle(sensor.measure(wall(depth), np.random.default_rng(0)))
        assert_allclose(measured.mean() - 1e3 * depth, expected, rtol=0.1)


def test_the_same_unit_and_frame_give_the_same_picture():
    first, again = (PAPER.measure(wall(0.8), np.random.default_rng(5)) for _ in range(2))
    assert (first == again).all()
    assert (first != D455(2, PRESETS["paper"], 848, 480).measure(wall(0.8), np.random.default_rng(5))).any()


def test_frozen_noise_stays_and_changes_with_the_pose():
    rng = np.random.default_rng(0)
    frames = [middle(PAPER.measure(wall(0.8), rng, pose=0)) for _ in range(8)]
    other = middle(PAPER.measure(wall(0.8), rng, pose=1))
    mean = np.mean(frames, axis=0)
    assert np.std(frames[0] - frames[1]) > 0.5  # temporal, mm
    assert np.std(mean - other) > 1.1 * np.std(mean - frames[0])


def test_the_left_band_is_blind_and_as_wide_as_the_disparity():
    measured = PAPER.measure(wall(0.75), np.random.default_rng(0))
    band = np.argmax(measured[240] > 0)
    assert_allclose(band, 53.8, atol=2.0)  # 425 px * 0.095 m / 0.75 m


def test_a_foreground_casts_a_shadow_to_its_left_only():
    depth = wall(1.5)
    depth[:, 400:600] = 0.7
    row = PAPER.measure(depth, np.random.default_rng(0))[200:280]
    assert (row[:, 374:396] == 0).mean() > 0.95  # 425 px * 0.095 m * (1 / 0.7 m - 1 / 1.5 m) = 30.8 px
    assert (row[:, 606:640] == 0).mean() < 0.05


def test_nothing_is_seen_nearer_than_the_least_distance():
    near = PAPER.nearest
    assert 0.30 < near < 0.35
    assert not PAPER.measure(wall(0.95 * near), np.random.default_rng(0)).any()
    assert middle(PAPER.measure(wall(1.1 * near), np.random.default_rng(0))).all()


def test_edges_fly_only_near_edges():
    depth = wall(1.5)
    depth[:, 400:600] = 0.7
    measured = PAPER.measure(depth, np.random.default_rng(0)).astype(float)
    measured[measured == 0] = np.nan
    between = (measured > 800) & (measured < 1450)
    columns = np.nonzero(between)[1]
    assert len(columns) > 100
    assert np.minimum(np.abs(columns - 400), np.abs(columns - 600)).max() <= 4


def test_warmth_shortens_distances_by_0_14_mm_per_degree():
    frames = [
        middle(PAPER.measure(wall(0.75), np.random.default_rng(0), celsius=c)).mean() for c in (30.0, 40.0)
    ]
    assert_allclose(frames[1] - frames[0], -1.4, atol=0.4)


def test_nothing_in_view_is_zero():
    assert not PAPER.measure(np.full(SIZE, np.nan, np.float32), np.random.default_rng(0)).any()


def test_water_makes_holes():
    dry = PAPER.measure(wall(0.8), np.random.default_rng(0))
    wet = PAPER.measure(wall(0.8), np.random.default_rng(0), air=Air(wetness=1.0, steam=0.5, drops=5))
    assert (wet == 0).mean() > (dry == 0).mean() + 0.02


def test_noise_has_unit_variance_at_every_width():
    rng = np.random.default_rng(0)
    for sigma in (2.0, 3.0, 15.0):
        assert_allclose(soft_noise(rng, (600, 800), sigma)[60:-60, 60:-60].std(), 1.0, rtol=0.15)


def test_published_numbers_are_the_factory_s_and_true_ones_lie_near():
    unit = make_unit(1, PRESETS["paper"], 848, 480)
    assert_allclose(unit.published_depth.fx, 641.5 * 848 / 1280)
    assert 0.0 < abs(unit.colour.fx / unit.published_colour.fx - 1.0) < 0.002
    off = np.linalg.inv(unit.published_T_colour_depth) @ unit.T_colour_depth
    assert_allclose(np.linalg.norm(off[:3, 3]), 0.0009, rtol=0.3)


@pytest.mark.parametrize(("seed", "preset", "serial"), [
    (1, PRESETS["paper"], "SIM455-0001-paper"),
    (1, PRESETS["good"], "SIM455-0001-good"),
    (23, PRESETS["yaw"], "SIM455-0023-yaw"),
    (1, replace(PRESETS["paper"], ripple=0.01), "SIM455-0001-custom"),
])  # fmt: skip
def test_the_serial_names_unit_and_preset(seed, preset, serial):
    assert make_unit(seed, preset, 848, 480).serial == serial


def test_a_perfect_unit_publishes_the_truth():
    unit = make_unit(7, PRESETS["perfect"], 848, 480)
    assert unit.depth == unit.published_depth
    assert unit.colour == unit.published_colour
    assert_allclose(unit.T_colour_depth, unit.published_T_colour_depth)


def test_frames_chain_to_the_published_extrinsics():
    unit = make_unit(1, PRESETS["paper"], 848, 480)
    edges = {(parent, child): transform for parent, child, transform in camera_frames(unit)}
    depth = (
        edges["camera_link", "camera_depth_frame"] @ edges["camera_depth_frame", "camera_depth_optical_frame"]
    )
    colour = (
        edges["camera_link", "camera_color_frame"] @ edges["camera_color_frame", "camera_color_optical_frame"]
    )
    assert_allclose(np.linalg.inv(colour) @ depth, unit.published_T_colour_depth, atol=1e-12)
    assert_allclose(T_LINK_OPTICAL[:3, 2], (1.0, 0.0, 0.0))  # looks along x of camera_link


@pytest.mark.parametrize("size", [(640, 480), (160, 90), (1920, 1080)])
def test_sizes_that_no_stream_has_are_refused(size):
    with pytest.raises(SettingsError, match="848x480"):
        make_unit(1, PRESETS["paper"], *size)


def test_an_unknown_preset_is_refused_with_the_names():
    with pytest.raises(SettingsError, match="paper, yaw, good, half, fixed, perfect"):
        find_preset("excellent")
