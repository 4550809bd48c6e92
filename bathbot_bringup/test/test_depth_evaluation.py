"""The evaluation of depth corrections: its rulers by hand, its laws, and one small run of the command."""

import json
from dataclasses import replace

import numpy as np
import pytest
from bathbot_bringup.command.arguments import count_or_seeds
from bathbot_bringup.command.cli import run
from bathbot_bringup.errors import InputError
from bathbot_bringup.evaluation.depth.measures import errors, flatness
from bathbot_bringup.evaluation.depth.methods.table import all_methods
from bathbot_bringup.evaluation.depth.simulated_unit import Recording, SimulatedUnit, facing
from bathbot_bringup.evaluation.depth.summary import interval, verdict
from bathbot_bringup.evaluation.depth.sweeps import SWEEPS, circumstances
from bathbot_bringup.evaluation.depth.table_2 import PUBLISHED_CORRECTED, PUBLISHED_RAW, replay
from bathbot_bringup.evaluation.depth.targets import DISTANCES, Cylinder, targets, wall
from bathbot_bringup.sim.camera.d455_unit import PRESETS
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_depthcorr.models.correction_model import Identity
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

CAMERA = Pinhole(320, 180, 160.0, 160.0, 160.0, 90.0)
RAYS = CAMERA.directions(CAMERA.pixel_grid())


@pytest.fixture(scope="module")
def unit():
    return SimulatedUnit(3, PRESETS["paper"], 320, 180)


@settings(max_examples=30, deadline=None)
@given(angles=st.tuples(*[st.floats(-3.0, 3.0)] * 3), radius=st.floats(0.02, 0.3), away=st.floats(0.5, 2.0))
def test_points_of_a_cylinder_lie_its_radius_from_its_axis(angles, radius, away):
    axis = Rotation.from_rotvec(angles).apply((1.0, 0.0, 0.0))
    cylinder = Cylinder(np.array([0.02, -0.03, away + radius]), axis, radius)
    points = RAYS * cylinder.depth_along(RAYS)[..., None]
    points = points[np.isfinite(points).all(axis=-1)] - cylinder.point
    assert_allclose(np.linalg.norm(np.cross(points, axis), axis=-1), radius, atol=1e-7)


def test_a_cylinder_moves_with_its_frame():
    cylinder = Cylinder(np.array([0.0, 0.0, 0.9]), np.array([0.0, 1.0, 0.0]), 0.1)
    turned = cylinder.transformed(transform_from(np.eye(3), (0.0, 0.0, 0.2)))
    assert turned.depth_along((0.0, 0.0, 1.0)) == pytest.approx(1.0)
    assert np.isnan(turned.depth_along((1.0, 0.0, 1.0)))


def test_only_what_faces_the_camera_is_judged():
    depth = Cylinder(np.array([0.0, 0.0, 0.9]), np.array([0.0, 1.0, 0.0]), 0.2).depth_along(RAYS)
    judged = facing(depth)
    assert judged[90, 160]
    assert not judged[np.isnan(depth)].any()
    assert 0.3 < judged.sum() / np.isfinite(depth).sum() < 1.0


def test_errors_by_hand():
    truth = np.full((20, 40), 1.0)
    depth = truth.copy()
    depth[:, :20] += 0.002
    depth[:, 20:] -= 0.001
    depth[0] = np.nan
    found = errors(depth, truth)
    assert_allclose(found[:2], (1.5, 0.5), atol=1e-9)
    assert found.percentile_95 == pytest.approx(2.0)
    assert found.fill == pytest.approx(0.95)


def test_a_perfect_wall_is_flat_and_a_shifted_one_as_flat_but_off():
    truth = wall(0.8, 0.2, -0.1).depth_along(RAYS)
    assert max(flatness(truth, truth, CAMERA, 61.0)) < 1e-3
    shifted = flatness(truth * 1.002, truth, CAMERA, 61.0)
    assert shifted.rmse < 1e-3
    assert shifted.point == pytest.approx(1.6, rel=0.2)


@given(st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=8))
def test_an_interval_holds_its_mean_and_lies_within_the_values(values):
    found = interval(values)
    assert min(values) - 1e-9 <= found.low <= found.mean + 1e-9
    assert found.mean - 1e-9 <= found.high <= max(values) + 1e-9


@pytest.mark.parametrize(
    ("values", "word"), [([0.2, 0.3, 0.25], "better"), ([-0.2, -0.1], "worse"), ([-0.1, 0.2], "level")]
)
def test_verdicts(values, word):
    assert verdict(interval(values)) == word


def test_one_unit_gives_no_verdict():
    assert verdict(interval([0.3])) == "one unit"


def test_the_published_table_has_the_published_means():
    assert round(PUBLISHED_RAW, 3) == 18.329
    assert round(PUBLISHED_CORRECTED, 3) == 1.111


def test_table_2_sees_the_raw_error_of_the_sensor(unit):
    found = replay(unit, {"none": Identity(unit.factory)}, draws=2)["none"]
    assert found.shape == (8, 2)
    assert 12.0 < np.nanmean(found) < 26.0


def test_a_unit_is_the_same_again_and_unlike_another():
    again, other = (SimulatedUnit(seed, PRESETS["paper"], 320, 180) for seed in (3, 4))
    truth = again.truth(wall(0.8))
    first = SimulatedUnit(3, PRESETS["paper"], 320, 180).frame(truth, 0, 0)
    np.testing.assert_array_equal(first, again.frame(truth, 0, 0))
    assert (again.frame(truth, 0, 0) != other.frame(truth, 0, 0)).mean() > 0.5


def test_clean_depth_is_what_many_frames_tend_to(unit):
    truth = unit.truth(wall(0.8, 0.1, 0.2))
    mean = np.mean([unit.frame(truth, 0, pose) for pose in range(12)], axis=0)
    assert np.nanmean(mean - unit.clean(truth)) == pytest.approx(0.0, abs=0.3e-3)


def test_wrong_squares_and_focal_lengths_are_what_they_say(unit):
    true, square, focal = (
        np.mean([view.distance for view in unit.calibration_views(recording)[0]])
        for recording in (
            Recording(10, 1), Recording(10, 1, square_error=0.01), Recording(10, 1, focal_error=0.01)
        )
    )  # fmt: skip
    assert square / true == pytest.approx(0.99, abs=0.004)  # a larger square looks nearer
    assert focal / true == pytest.approx(1.01, abs=0.004)


def test_wrong_matches_are_as_many_as_asked(unit):
    clean, spoilt = (
        unit.calibration_views(Recording(10, 1, outliers=share))[0][0].depth for share in (0.0, 0.05)
    )
    moved = np.abs(spoilt - clean) > 0.02
    assert moved[np.isfinite(clean)].mean() == pytest.approx(0.05, abs=0.01)


@pytest.mark.parametrize("name", sorted(SWEEPS))
def test_a_sweep_changes_one_thing(name):
    values = SWEEPS[name][1]
    usual = (PRESETS["paper"], Recording())
    found = [circumstances(name, value, PRESETS["paper"]) for value in values]
    assert usual in found
    assert len({str(each) for each in found}) == len(values)
    assert all((preset == usual[0]) or (recording == usual[1]) for preset, recording in found)


def test_every_unit_has_other_targets():
    kinds = [target.kind for target in targets(0)]
    assert kinds.count("wall") == 3 * len(DISTANCES)
    assert {"working", "cylinder"} <= set(kinds)
    first, other = (target.surface for target in (targets(0)[1], targets(1)[1]))
    assert not np.allclose(first.normal, other.normal)


def test_seeds_are_counted_or_named():
    assert count_or_seeds("3") == [0, 1, 2]
    assert count_or_seeds("3-4,7") == [3, 4, 7]
    for wrong in ("0", "x", "20000"):
        with pytest.raises(InputError):
            count_or_seeds(wrong)


def test_the_command_writes_numbers_and_pictures(tmp_path, capsys):
    line = "evaluate depth --seeds 1 --size 320x180 --poses 10 --frames 1"
    file = tmp_path / "depth.json"
    assert run([*line.split(), "--json", str(file), "--figures", str(tmp_path)]) == 0
    result = json.loads(file.read_text())
    assert set(result["systematic_mm"]) == set(all_methods())
    assert list(result["systematic_mm"]["two_stage"]) == [str(z) for z in DISTANCES]
    assert 14.0 < result["raw_mm"] < 24.0
    assert 0.0 < result["one_frame_mm"] < result["frames"]["none"]["absolute"]
    assert 0.0 < result["rmse_mm"] < 20.0
    assert [row["no"] for row in result["table2"]] == list(range(1, 9))
    assert result["simulated"] is True
    pictures = {path.name for path in tmp_path.glob("*.png")}
    assert pictures == {"depth_error.png", "depth_maps.png", "depth_parts.png", "depth_table_2.png"}
    assert "disparity_spline" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("--preset", "magic"), "no D455 preset 'magic'"),
        (("--size", "640x480"), "16:9 pictures"),
        (("--poses", "4"), "--poses"),
        (("--json", "/dev/null/depth.json"), "/dev/null"),
    ],
)
def test_mistakes_are_one_line(change, words, capsys):
    assert run(["evaluate", "depth", *change]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1


def test_a_ripple_of_another_size_leaves_the_rest_alone():
    preset, recording = circumstances("ripple", 0.08, PRESETS["yaw"])
    assert preset == replace(PRESETS["yaw"], ripple=0.08)
    assert recording == Recording()
