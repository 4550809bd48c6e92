from dataclasses import replace

import numpy as np
import pytest
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.live.frame_quality import Centre, quality_values
from bathbot_depthcorr.live.live_correction import LiveCorrection
from bathbot_depthcorr.live.settings import Settings
from bathbot_depthcorr.models.disparity_spline import DisparitySpline
from bathbot_depthcorr.ros.camera_health import CameraHealth
from bathbot_depthcorr.ros.verdict import Level
from numpy.testing import assert_allclose, assert_array_equal

CAMERA = Pinhole(160, 90, 80.0, 80.0, 80.0, 45.0)
UNIT = CameraUnit(CAMERA, serial="UNIT-7", temperature=30.0)
NOISE = 0.02  # [px]


def correction(offset=0.0):
    return DisparitySpline(
        UNIT, np.zeros((4, 4)), np.full((4, 4), offset), np.zeros(4), NOISE, np.zeros((3, 4, 4))
    )


def wall(distance=0.75, noise=0.0, seed=0):
    shape = (CAMERA.height, CAMERA.width)
    return (distance + np.random.default_rng(seed).normal(0.0, noise, shape)).astype(np.float32)


def judged(*frames, stored=True, **settings):
    """A live correction that has seen frames and looked closely at the last."""
    live = LiveCorrection(Settings(**settings), correction() if stored else None)
    live.meet_camera(CAMERA)
    live.meet_health(CameraHealth("UNIT-7", 31.0))
    for frame in frames:
        corrected = live.process(frame)
    live.judge(corrected)
    return live


def values(live, wall_distance=0.0):
    return quality_values(live.quality, wall_distance)


def test_it_waits_for_camera_info_then_for_frames_then_corrects():
    live = LiveCorrection(Settings(), correction())
    assert live.verdict().level is Level.WARN
    assert "camera_info" in live.verdict().message
    assert live.process(wall()) is None
    live.meet_camera(CAMERA)
    assert live.verdict().message.startswith("waiting for depth images")
    live.judge(live.process(wall()))
    assert live.verdict() == (Level.OK, "correcting")
    live.lose_sight()
    assert live.verdict().message.startswith("waiting for depth images")


def test_a_frame_is_written_where_it_is_wanted():
    live, out = judged(wall()), np.empty((90, 160), np.float32)
    assert live.process(wall(), out) is out
    assert_array_equal(out, wall())


def test_far_depth_and_no_depth_are_none():
    frame = wall()
    frame[:, :40], frame[:, 40:60] = np.nan, 5.0
    corrected = judged(wall(), max_depth=4.0).process(frame)
    assert np.isnan(corrected[:, :60]).all()
    assert np.isfinite(corrected[:, 60:]).all()


@pytest.mark.parametrize(
    ("camera", "serial"), [(Pinhole(160, 90, 81.0, 80.0, 80.0, 45.0), "UNIT-7"), (CAMERA, "UNIT-8")]
)
def test_another_camera_is_refused_until_the_right_one_comes_back(camera, serial):
    live = judged(wall())
    live.meet_camera(camera)
    live.meet_health(CameraHealth(serial, 31.0))
    assert live.verdict().level is Level.ERROR
    assert live.process(wall()) is None
    live.meet_camera(CAMERA)
    live.meet_health(CameraHealth("UNIT-7", 31.0))
    assert live.process(wall()) is not None


def test_a_temperature_far_from_the_calibration_is_a_warning():
    live = judged(wall())
    live.meet_health(CameraHealth("UNIT-7", 38.5))
    assert live.verdict() == (
        Level.WARN, "camera is +8.5 deg C from its calibration; let it warm up or calibrate again"
    )  # fmt: skip


def test_a_wall_is_judged_by_its_flatness_noise_and_sigma():
    live = judged(wall(noise=1e-3, seed=1), wall(noise=1e-3, seed=2))
    quality = live.quality
    assert quality.is_plane
    assert_allclose([quality.plane_rmse, quality.noise], 1e-3, rtol=0.1)
    assert_allclose(quality.sigma, 0.75**2 / UNIT.focal_baseline * NOISE, rtol=1e-3)
    assert quality.fill == 1.0
    assert values(live)["z_accuracy"] == "unknown"


def test_z_accuracy_needs_a_known_wall():
    live = judged(wall(0.765), wall_distance=0.75)
    assert values(live, 0.75)["z_accuracy"] == "+2.00 %"


def test_what_is_no_plane_is_said_to_be_none():
    frame = wall()
    frame[:, 80:] = 1.5
    told = values(judged(frame, wall_distance=0.75), 0.75)
    assert told["plane_rmse_mm"].startswith("no plane (")
    assert told["z_accuracy"] == "no plane"


def test_flying_pixels_do_not_make_a_wall_uneven():
    frame = wall(noise=5e-4)
    centre = Centre(CAMERA)
    frame[centre.window][0, :5] = 3.0
    assert judged(frame).quality.plane_rmse < 6e-4


def test_things_before_a_wall_do_not_tilt_the_plane():
    """A tenth of the points at half the distance: no plane, but accuracy is not asked of a phantom."""
    frame = wall(1.5, noise=5e-4)
    frame[30:33] = 0.7
    told = values(judged(frame, wall_distance=1.5), 1.5)
    assert told["z_accuracy"] == "no plane"


def test_an_empty_frame_is_an_error_and_has_no_numbers():
    live = judged(np.full((90, 160), np.nan, np.float32))
    assert live.verdict().level is Level.ERROR
    assert "0.0% of the pixels" in live.verdict().message
    told = values(live)
    assert told.pop("fill") == "0.000"
    assert set(told.values()) == {"unknown"}


def test_before_the_first_frame_all_is_unknown():
    assert set(quality_values(None, 0.75).values()) == {"unknown"}


def test_without_calibration_depth_passes_with_a_warning():
    live = judged(wall(), stored=False)
    assert live.verdict().level is Level.WARN
    assert "uncorrected" in live.verdict().message
    assert_array_equal(live.process(wall()), wall())


def test_a_region_that_cannot_be_made_is_the_verdict_unless_something_is_worse():
    live = judged(wall(), registered_roi=(0, 0, 400, 400))
    assert live.verdict() == (Level.OK, "correcting"), "the colour camera is not known yet"
    live.region.meet_colour_camera(CAMERA)
    assert live.verdict().level is Level.ERROR
    assert live.verdict().message.startswith("registered_roi: ")
    live.meet_camera(replace(CAMERA, fx=90.0))
    assert "fx" in live.verdict().message


def test_its_values_name_the_camera_its_frames_and_their_quality():
    told = judged(wall(), registered_roi=(0, 0, 0, 0)).values(14.96, 3)
    assert list(told)[:5] == ["model", "serial", "fps", "dropped", "temperature"]
    assert (told["model"], told["serial"]) == ("disparity_spline", "UNIT-7")
    assert (told["fps"], told["dropped"], told["temperature"]) == ("15.0", "3", "31.0")
    assert told["fill"] == "1.000"
    nothing = LiveCorrection(Settings(), None).values(0.0, 0)
    assert (nothing["model"], nothing["serial"], nothing["fill"]) == ("none", "unknown", "unknown")
