"""The demo corrects with the calibration of the camera that it simulates, and refuses any other."""

from dataclasses import replace

import pytest
from bathbot_bringup.bathing.nodes import demo_nodes
from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.command.cli import run
from bathbot_bringup.evaluation.demo import demo_arguments
from bathbot_bringup.graph.installation import SIM_CALIBRATION
from bathbot_bringup.graph.isolation import Ports
from bathbot_bringup.sim.camera.sim_camera_settings import SimCameraSettings
from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.files import CalibrationFileError
from bathbot_depthcorr.models.correction_model import Identity


@pytest.fixture
def good(tmp_path):
    """A file such as the user makes for preset good."""
    correction = load(SIM_CALIBRATION)
    correction.unit = replace(correction.unit, serial="SIM455-0001-good")
    correction.save(tmp_path / "good.npz")
    return tmp_path / "good.npz"


def test_the_calibration_that_comes_with_it_is_of_the_default_camera():
    unit = load(SIM_CALIBRATION).unit
    camera = SimCameraSettings().unit()
    assert unit.serial == camera.serial == "SIM455-0001-paper"
    unit.refuse_other(camera.published_depth, camera.serial)


@pytest.mark.parametrize("command", ["demo", "evaluate demo --seeds 0", "evaluate localization --seeds 0"])
@pytest.mark.parametrize("preset", ["good", "yaw"])
def test_another_preset_is_refused_before_anything_starts(command, preset, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run([*command.split(), "--preset", preset]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is for camera SIM455-0001-paper" in line
    assert f"preset {preset} simulates SIM455-0001-{preset}" in line
    assert f"bathbot simulate board --preset {preset} --out wall" in line
    assert "bathbot calibrate depth wall --out" in line
    assert "--calibration" in line
    assert not list(tmp_path.iterdir())


def test_its_own_calibration_is_taken_and_handed_to_the_corrector(good, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    settings = DemoSettings(
        "Trunk_skin", 0, "calm", tmp_path / "out", preset="good", calibration=good.relative_to(tmp_path)
    )
    nodes = demo_nodes(settings, 0.0, Ports(1, 2), tmp_path / "bag")
    assert nodes["depth_corrector"]["calibration"] == good
    arguments = demo_arguments(settings)
    assert arguments[arguments.index("--calibration") + 1] == str(good)


def test_a_calibration_of_the_wrong_preset_or_none_is_refused(good, tmp_path):
    with pytest.raises(Exception, match="is for camera SIM455-0001-good, preset paper simulates"):
        DemoSettings("Trunk_skin", 0, "calm", tmp_path / "out", calibration=good)
    with pytest.raises(CalibrationFileError, match="no depth calibration at"):
        DemoSettings("Trunk_skin", 0, "calm", tmp_path / "out", calibration=tmp_path / "none.npz")


def test_a_calibration_of_another_size_is_told_by_its_size(tmp_path):
    unit = load(SIM_CALIBRATION).unit
    Identity(replace(unit, depth_camera=unit.depth_camera.scaled(640, 360))).save(tmp_path / "small.npz")
    with pytest.raises(Exception, match="does not fit: calibration is for 640x360, camera sends"):
        DemoSettings("Trunk_skin", 0, "calm", tmp_path / "out", calibration=tmp_path / "small.npz")
