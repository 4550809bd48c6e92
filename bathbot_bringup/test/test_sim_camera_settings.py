"""Parameters of the simulated camera."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
import yaml
from bathbot_bringup.errors import SettingsError
from bathbot_bringup.sim.camera.d455_camera import ColourNoise, D455Camera
from bathbot_bringup.sim.camera.sim_camera_settings import SCENES, SimCameraSettings
from bathbot_scrub.installed_arm import installed_arm

CONFIG = Path(__file__).parents[1] / "config" / "sim_camera.yaml"


def test_the_file_has_the_fields_and_the_defaults_of_the_settings():
    parameters = yaml.safe_load(CONFIG.read_text())["sim_camera"]["ros__parameters"]
    assert parameters == {field.name: field.default for field in fields(SimCameraSettings)}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        pytest.param({"scene": "kitchen"}, "bathroom, chessboard, aruco", id="scene"),
        pytest.param({"preset": "best"}, "paper, yaw, good", id="preset"),
        pytest.param({"scenario": "dancing"}, "no scenario", id="scenario"),
        pytest.param({"rate": 0.0}, "rate must lie", id="rate"),
        pytest.param({"epoch": -1.0}, "epoch must be 0 s or more", id="epoch"),
        pytest.param({"seed": -3}, "seed must lie", id="seed"),
    ],
)
def test_bad_values_are_refused(change, message):
    with pytest.raises(SettingsError, match=message):
        SimCameraSettings(**change)


@pytest.mark.parametrize("scene", SCENES)
def test_every_scene_gives_a_pair_of_pictures(scene):
    camera = D455Camera(SimCameraSettings(scene=scene, width=424, height=240, poses=3))
    shot = camera.shoot(0.1, installed_arm().home)
    assert shot.colour.shape == (240, 424, 3)
    assert shot.colour.dtype == np.uint8
    assert 0.3 < np.isfinite(shot.depth).mean() < 1.0
    assert np.nanmin(shot.depth) > 0.1


def test_colour_noise_is_as_strong_as_said():
    noise = ColourNoise((240, 424), 3.0, seed=0)
    noisy = noise.add(np.full((240, 424, 3), 128, np.uint8), np.random.default_rng(0))
    assert abs(noisy.std() - 3.0) < 0.3
    clean = np.full((4, 4, 3), 7, np.uint8)
    assert (ColourNoise((4, 4), 0.0, seed=0).add(clean, np.random.default_rng(0)) == clean).all()


def test_a_picture_shows_arm_and_person_of_one_moment():
    camera = D455Camera(SimCameraSettings(width=424, height=240))
    assert camera.next_moment(1.0) == (1.0, None)
    camera.hear_arm(np.arange(6.0), 10.0)
    moment, joints = camera.next_moment(10.15)
    assert moment == 10.0
    assert (joints == np.arange(6.0)).all()


def test_joint_angles_that_are_old_no_longer_tell_the_moment_and_soon_not_the_arm():
    camera = D455Camera(SimCameraSettings(width=424, height=240))
    camera.hear_arm(np.arange(6.0), 10.0)
    assert camera.next_moment(10.1)[0] == 10.0
    assert camera.next_moment(10.15)[0] == 10.15  # no moment twice
    moment, joints = camera.next_moment(11.9)
    assert moment == 11.9
    assert (joints == np.arange(6.0)).all()
    assert camera.next_moment(12.1) == (12.1, None)
