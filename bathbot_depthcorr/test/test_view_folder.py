"""Folders of .npz views: the documented format, what comes back, and what is refused."""

import json

import numpy as np
import pytest
from bathbot_depthcorr.calibration.calibrate import calibrate_bag
from bathbot_depthcorr.calibration.guards import CalibrationRefusedError
from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.geometry.rigid import inverse
from bathbot_depthcorr.views.colour_reference import ViewSet
from bathbot_depthcorr.views.view_folder import (
    ViewFolderError,
    is_view_folder,
    read_view_folder,
    write_view,
    write_view_folder,
)
from depthcorr_wall import Sensor, wall, walls
from numpy.testing import assert_allclose

SENSOR = Sensor(seed=4, width=424, height=240, least_depth=0.2)
CAMERA = {
    "width": 424, "height": 240, "fx": SENSOR.camera.fx, "fy": SENSOR.camera.fy, "cx": SENSOR.camera.cx,
    "cy": SENSOR.camera.cy, "baseline": 0.095, "T_colour_depth": SENSOR.T_colour_depth.tolist(),
}  # fmt: skip


def seen(*planes, seed=0, frames=2, plane_error=2e-4, sensor=SENSOR):
    rng = np.random.default_rng(seed)
    return [sensor.view(plane, rng, frames, plane_error=plane_error) for plane in planes]


@pytest.fixture
def folder(tmp_path):
    """A folder with a camera and one view; tests change the contents."""
    folder = tmp_path / "views"
    folder.mkdir()
    (folder / "camera.json").write_text(json.dumps(CAMERA))
    return folder


def contents(**changes):
    plane = wall(0.8, 0.2, -0.1)
    values = {"depth": seen(plane)[0].depth, "plane": np.append(plane.normal, plane.offset)} | changes
    return {key: value for key, value in values.items() if value is not None}


def refused(folder, words):
    with pytest.raises(ViewFolderError, match=words) as caught:
        read_view_folder(folder)
    assert "\n" not in str(caught.value)


def test_what_is_written_comes_back(tmp_path):
    views = seen(wall(0.6), wall(0.9, 0.3, -0.2), wall(1.4, -0.1, 0.1))
    write_view_folder(tmp_path / "views", ViewSet(views, SENSOR.factory))
    assert is_view_folder(tmp_path / "views")
    found = read_view_folder(tmp_path / "views")
    assert found.unit.depth_camera == SENSOR.camera
    assert (found.unit.serial, found.unit.temperature) == ("TEST-1", 30.0)
    assert_allclose(found.unit.T_colour_depth, SENSOR.factory.T_colour_depth)
    for before, after in zip(views, found.views, strict=True):
        assert_allclose(after.depth, before.depth, rtol=1e-6)
        assert_allclose(after.plane.normal, before.plane.normal)
        assert after.plane.offset == pytest.approx(before.plane.offset)
        assert_allclose(after.covariance, before.covariance)
        assert (after.frames, after.temporal_noise) == (before.frames, before.temporal_noise)


@pytest.mark.parametrize("form", ["metres", "millimetres", "zeros for none", "frames"])
def test_depth_in_every_form(folder, form):
    expected = contents()["depth"]
    mm = np.round(np.nan_to_num(expected) * 1000.0).astype(np.uint16)
    depth = {
        "metres": {"depth": expected}, "millimetres": {"depth": mm},
        "zeros for none": {"depth": np.nan_to_num(expected)},
        "frames": {"depth": None, "frames": np.stack([mm] * 3)},
    }[form]  # fmt: skip
    np.savez(folder / "a.npz", **contents(**depth))
    (view,) = read_view_folder(folder).views
    assert_allclose(view.depth, expected, atol=6e-4)
    assert view.frames == (3 if form == "frames" else 1)


@pytest.mark.parametrize("form", ["plane", "scaled", "turned", "plane_depth", "true_depth"])
def test_the_plane_in_every_form(folder, form):
    true = wall(0.8, 0.2, -0.1)
    plane = np.append(true.normal, true.offset)
    inside = true.transformed(inverse(SENSOR.T_colour_depth))
    given = {
        "plane": {}, "scaled": {"plane": 3.0 * plane}, "turned": {"plane": -plane},
        "plane_depth": {"plane": None, "plane_depth": np.append(inside.normal, inside.offset)},
        "true_depth": {"plane": None, "true_depth": SENSOR.truth(true)},
    }[form]  # fmt: skip
    np.savez(folder / "a.npz", **contents(**given))
    (view,) = read_view_folder(folder).views
    assert_allclose(view.plane.normal, true.normal, atol=1e-6)
    assert view.plane.offset == pytest.approx(true.offset, abs=1e-6)


@pytest.mark.parametrize("place", ["json", "npz", "each file"])
def test_the_camera_in_every_place(folder, place):
    if place != "json":
        (folder / "camera.json").unlink()
    if place == "npz":
        np.savez(folder / "camera.npz", **CAMERA)
    np.savez(folder / "a.npz", **contents(**(CAMERA if place == "each file" else {})))
    found = read_view_folder(folder)
    assert found.unit.depth_camera == SENSOR.camera
    assert len(found.views) == 1


@pytest.mark.parametrize(("changes", "words"), [
    pytest.param({"depth": None}, "either depth or frames, it has plane", id="no depth"),
    pytest.param({"depth": np.ones((24, 42))}, r"depth has shape \(24, 42\), the camera has \(", id="size"),
    pytest.param({"depth": np.full((240, 424), 812.0)}, "median of 812 m; whole numbers are", id="float mm"),
    pytest.param({"depth": np.full((240, 424), 1)}, "median of 0.001 m", id="whole metres"),
    pytest.param({"depth": np.full((240, 424), "far")}, "depth has type <U3", id="words"),
    pytest.param({"plane": None}, "one of plane, plane_depth, true_depth, it has none", id="no plane"),
    pytest.param({"plane_depth": np.ones(4)}, "it has plane, plane_depth", id="two planes"),
    pytest.param({"plane": np.ones(3)}, r"plane must be finite and have shape \(4,\)", id="three numbers"),
    pytest.param({"plane": np.full(4, np.nan)}, "plane must be finite", id="nan"),
    pytest.param({"plane": np.zeros(4)}, "is no wall before the camera", id="no direction"),
    pytest.param({"plane": None, "true_depth": np.random.default_rng(0).uniform(0.5, 1.5, (240, 424))},
                 "mm RMS off its plane", id="no plane in depth"),
    pytest.param({"covariance": np.eye(2)}, r"covariance must .* shape \(3, 3\)", id="covariance"),
    pytest.param({"fx": np.nan}, "fx must be finite", id="focal length"),
    pytest.param({"fx": -3.0}, "describe no camera", id="no camera"),
    pytest.param({"baseline": 95.0}, "baseline must be 0.005 to 1 m, got 95.0", id="baseline in mm"),
    pytest.param({"T_colour_depth": np.zeros((4, 4))}, "holds no rotation", id="no rotation"),
])  # fmt: skip
def test_bad_contents(folder, changes, words):
    np.savez(folder / "a.npz", **contents(**changes))
    refused(folder, f"a.npz: .*{words}")


def test_a_second_camera(folder):
    np.savez(folder / "a.npz", **contents())
    np.savez(folder / "b.npz", **contents(serial="B"))
    refused(folder, "b.npz: its camera, B .* is not the first view's, unnamed")


def test_damaged_files(folder):
    refused(folder, "holds no .npz views")
    assert not is_view_folder(folder)
    write_view(folder / "a.npz", seen(wall(0.8))[0])
    whole = (folder / "a.npz").read_bytes()
    for cut in (b"", b"text", whole[: len(whole) // 2], whole[:-10]):
        (folder / "a.npz").write_bytes(cut)
        refused(folder, "cannot read .*a.npz: .*complete")
    (folder / "a.npz").write_bytes(whole)
    for text, words in (
        ("{", "cannot read .*camera.json"),
        ("[1]", "holds a list"),
        ("{}", "camera's width, "),
    ):
        (folder / "camera.json").write_text(text)
        refused(folder, words)


def test_a_folder_becomes_a_calibration(tmp_path):
    sensor = Sensor(seed=4, width=212, height=120, least_depth=0.2)  # small: six fits are made
    views = seen(*walls(np.random.default_rng(1), 18), sensor=sensor)
    write_view_folder(tmp_path / "views", ViewSet(views, sensor.factory))
    report = calibrate_bag(tmp_path / "views", tmp_path / "unit.npz")
    assert report.after < 0.2 * report.before
    assert load(tmp_path / "unit.npz").serial == "TEST-1"
    assert not any("focal" in line for line in report.references())
    assert [point.views for point in report.learning] == [6, 9, 12, 14]


def test_public_data_of_six_frontal_distances_is_tried(tmp_path):
    """Such as mean depth maps from 0.4 to 0.9 m with the true depth of each: no board, no tilt."""
    planes = [wall(z) for z in np.linspace(0.4, 0.9, 6)]
    write_view_folder(tmp_path / "views", ViewSet(seen(*planes, frames=1, plane_error=0.0), SENSOR.factory))
    report = calibrate_bag(tmp_path / "views", tmp_path / "unit.npz")
    assert report.after < 0.2 * report.before
    said = " ".join(report.warnings)
    assert "0% of the views are tilted" in said
    assert "6 views; 18 or more halve the error" in said


@pytest.mark.parametrize(("planes", "words"), [
    pytest.param([wall(z) for z in np.linspace(0.4, 0.9, 4)], "4 usable views", id="four distances"),
    pytest.param([wall(z) for z in (0.4, 0.6, 0.8)] * 5, "only 3 of 15 views differ", id="repeated"),
    pytest.param([wall(z) for z in np.linspace(0.7, 0.85, 6)], "must be 1.3 times", id="near together"),
])  # fmt: skip
def test_public_data_with_too_few_poses_is_refused_with_the_number(tmp_path, planes, words):
    write_view_folder(tmp_path / "views", ViewSet(seen(*planes, frames=1, plane_error=0.0), SENSOR.factory))
    with pytest.raises(CalibrationRefusedError, match=words):
        calibrate_bag(tmp_path / "views", tmp_path / "unit.npz")
    assert not list(tmp_path.glob("unit*"))
