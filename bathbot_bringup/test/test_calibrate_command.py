"""`bathbot calibrate depth` as a user meets it: mistakes are one line, Ctrl-C is 130, files are whole."""

import json

import numpy as np
import pytest
from bathbot_bringup.command.arguments import picture_size
from bathbot_bringup.command.cli import run
from bathbot_bringup.errors import InputError
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import Plane
from bathbot_depthcorr.models.table import MODELS
from bathbot_depthcorr.views.colour_reference import ViewSet
from bathbot_depthcorr.views.view_folder import write_view_folder
from bathbot_depthcorr.views.views import CalibrationView
from scipy.spatial.transform import Rotation

CAMERA = Pinhole(320, 180, 160.0, 160.0, 160.0, 90.0)


def wall_view(distance, tilts):
    normal = Rotation.from_euler("xy", tilts).apply((0.0, 0.0, -1.0))
    plane = Plane(normal, float(normal[2] * distance))
    depth = 1.01 * plane.depth_along(CAMERA.directions(CAMERA.pixel_grid()))
    return CalibrationView(depth.astype(np.float32), plane)


@pytest.fixture
def folder(tmp_path):
    """Views of a camera that reads 1 % too far, without noise."""
    rng = np.random.default_rng(0)
    views = [wall_view(distance, rng.uniform(-0.4, 0.4, 2)) for distance in np.linspace(0.5, 1.4, 12)]
    write_view_folder(tmp_path / "views", ViewSet(views, CameraUnit(CAMERA, serial="A")))
    return tmp_path / "views"


def complaint(capsys, *arguments):
    assert run(["calibrate", "depth", *map(str, arguments)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("bathbot: ")
    return line


def test_a_folder_of_views_becomes_files_and_a_table(folder, tmp_path, capsys):
    out, report, views = tmp_path / "a.npz", tmp_path / "a.json", tmp_path / "again"
    arguments = [folder, "--out", out, "--json", report, "--views", views]
    assert run(["calibrate", "depth", *map(str, arguments)]) == 0
    said = capsys.readouterr().out
    assert "errors on 3 held out" in said
    assert "raw depth: 1.0100 times the true distance" in said
    numbers = json.loads(report.read_text())
    assert numbers["before_mm"] > 5.0 > 20.0 * numbers["after_mm"]
    assert [point["views"] for point in numbers["learning"]] == [6, 9]
    assert len(list(views.glob("*.npz"))) == 12
    assert (tmp_path / "a.png").exists()


def test_mistakes_before_the_work_begins(folder, tmp_path, capsys):
    out = tmp_path / "a.npz"
    assert "either a bag, or --live" in complaint(capsys, "--out", out)
    assert "either a bag, or --live" in complaint(capsys, folder, "--live", "--out", out)
    assert "views exists already" in complaint(capsys, folder, "--out", out, "--views", folder)
    assert "does not exist" in complaint(capsys, folder, "--out", out, "--json", tmp_path / "no" / "a.json")
    assert "must end in .npz" in complaint(capsys, "--live", "--out", tmp_path / "a.yaml")
    assert "unknown depth model 'magic'" in complaint(capsys, "--live", "--out", out, "--model", "magic")
    assert [file.name for file in tmp_path.iterdir()] == ["views"]


def test_a_bad_view_is_named(folder, tmp_path, capsys):
    (folder / "view_003.npz").write_bytes(b"cut off")
    assert "view_003.npz" in complaint(capsys, folder, "--out", tmp_path / "a.npz")
    assert [file.name for file in tmp_path.iterdir()] == ["views"]


def test_an_interrupted_fit_writes_nothing(folder, tmp_path, monkeypatch, capsys):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setitem(MODELS, "two_stage", MODELS["two_stage"]._replace(fit=interrupt))
    arguments = ["calibrate", "depth", str(folder), "--model", "two_stage", "--out", str(tmp_path / "a.npz")]
    assert run(arguments) == 130
    assert "stopped fit two_stage" in capsys.readouterr().out.replace("  ", " ")
    assert [file.name for file in tmp_path.iterdir()] == ["views"]


@pytest.mark.parametrize("text", ["", "848", "848*480", "9x9", "848x480x3"])
def test_bad_sizes_are_refused(text):
    with pytest.raises(InputError, match="such as 848x480"):
        picture_size(text)


def test_sizes_of_a_simulated_board(tmp_path, capsys):
    assert picture_size(" 640x360 ") == (640, 360)
    assert run(["simulate", "board", "--out", str(tmp_path / "x"), "--size", "640x480"]) == 2
    assert "16:9 pictures 320 to 1280 px wide, got 640x480" in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
