"""A depth model is one class and one row: everything else reads the table."""

import numpy as np
import pytest
from bathbot_bringup.bench.scene import bench_camera, bench_corrections, bench_frames
from bathbot_bringup.command.cli import run
from bathbot_bringup.evaluation.depth.evaluate_unit import evaluate_unit
from bathbot_bringup.evaluation.depth.figures import save_figures
from bathbot_bringup.evaluation.depth.methods.table import OTHERS, all_methods
from bathbot_bringup.evaluation.depth.simulated_unit import Recording, SimulatedUnit
from bathbot_bringup.evaluation.depth.summary import summarise
from bathbot_bringup.sim.camera.d455_unit import find_preset
from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.models.correction_model import Correction
from bathbot_depthcorr.models.table import DEFAULT_MODEL, MODELS, PAPERS_MODEL, DepthModel
from bathbot_depthcorr.views.colour_reference import ViewSet
from bathbot_depthcorr.views.view_folder import write_view_folder
from bathbot_depthcorr.views.views import true_depth
from matplotlib.colors import is_color_like


class Longer(Correction):
    """Z' = factor Z."""

    model = "longer"

    def __init__(self, unit, factor):
        super().__init__(unit)
        self.factor = np.float32(factor)

    def apply(self, depth, out=None):
        return np.multiply(self.check_shape(depth), self.factor, out=self.output(out))

    def sigma(self, depth):
        return 0.01 * self.check_shape(depth)

    def arrays(self):
        return {"factor": np.float64(self.factor)}

    @classmethod
    def from_arrays(cls, unit, arrays):
        return cls(unit, float(arrays["factor"]))

    @classmethod
    def drawn(cls, unit, rng):
        return cls(unit, rng.normal(1.0, 0.01))


def fit_longer(views, unit):
    return Longer(unit, np.nanmedian([true_depth(view, unit) / view.depth for view in views]))


@pytest.fixture
def row(monkeypatch):
    """The one row."""
    row = DepthModel(Longer, fit_longer, "one factor, to be seen in the help", "tab:pink")
    monkeypatch.setitem(MODELS, "longer", row)
    return row


@pytest.fixture(scope="module")
def unit():
    return SimulatedUnit(1, find_preset("paper"), 424, 240)


@pytest.mark.parametrize("name", MODELS)
def test_each_row_stands_under_the_name_of_its_class_and_can_be_drawn_and_told(name):
    row = MODELS[name]
    assert row.kind.model == name
    assert row.about
    assert "\n" not in row.about
    assert is_color_like(row.colour)


def test_the_table_of_the_evaluation_shows_no_colour_twice():
    colours = [method.colour for method in all_methods().values()]
    assert len(set(colours)) == len(colours)


def test_a_new_model_is_fitted_saved_and_loaded(row, unit, tmp_path, capsys):
    views, _ = unit.calibration_views(Recording(poses=18, frames=2))
    write_view_folder(tmp_path / "views", ViewSet(views, unit.factory))
    out = tmp_path / "a.npz"
    assert run(["calibrate", "depth", str(tmp_path / "views"), "--model", "longer", "--out", str(out)]) == 0
    found = load(out)
    assert isinstance(found, Longer)
    assert found.factor == pytest.approx(fit_longer(views, unit.factory).factor)
    assert abs(found.factor - 1.0) > 0.005  # preset paper reads long


def test_the_help_and_the_refusal_of_another_name_it(row, tmp_path, capsys):
    assert run(["calibrate", "depth", "--help"]) == 0
    assert "longer            one factor, to be seen in the help" in capsys.readouterr().out
    assert run(["calibrate", "depth", "--live", "--model", "short", "--out", str(tmp_path / "a.npz")]) == 2
    assert "'short'; known are disparity_spline, two_stage, two_imager, identity, longer" in (
        capsys.readouterr().err
    )


def test_the_bench_times_it(row):
    camera = bench_camera(160, 90)
    assert isinstance(bench_corrections(camera)["longer"], Longer)
    frame = bench_frames(camera, 1)[0]
    assert np.nanstd(bench_corrections(camera)["longer"].apply(frame) / frame) < 1e-6


def test_the_evaluation_judges_it_and_draws_it(row, unit, tmp_path):
    names = list(all_methods())
    assert names == [*OTHERS, PAPERS_MODEL, "two_imager", "longer", DEFAULT_MODEL]
    assert all_methods()["longer"][1:] == (row.about, row.colour)
    chosen = ["none", PAPERS_MODEL, "longer", DEFAULT_MODEL]
    result, fitted = evaluate_unit(unit, Recording(poses=12, frames=2), chosen, lambda _: None)
    summary = {**summarise([result], chosen), "table2": [], "sweeps_mm": {}}
    assert summary["working_mm"]["longer"] < 0.5 * summary["working_mm"]["none"]
    maps = {name: {0.75: np.ones((9, 16)), 1.5: np.ones((9, 16))} for name in fitted}
    assert len(save_figures(tmp_path, summary, maps)) == 4


def test_a_model_that_is_not_to_be_judged_is_not(row, monkeypatch):
    monkeypatch.setitem(MODELS, "longer", row._replace(judged=False))
    assert "longer" not in all_methods()
    assert "longer" not in bench_corrections(bench_camera(160, 90))
