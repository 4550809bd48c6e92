"""The corrections of others on a simulated unit: what is known of them, they reach."""

import numpy as np
import pytest
from bathbot_bringup.evaluation.depth.methods.table import all_methods
from bathbot_bringup.evaluation.depth.simulated_unit import Recording, SimulatedUnit
from bathbot_bringup.evaluation.depth.targets import wall
from bathbot_bringup.sim.camera.d455_unit import find_preset

BASELINES = ["none", "tare", "global_quadratic", "clams", "herrera", "basso"]
JOINT = ["global_quadratic", "herrera", "basso", "two_stage"]


def test_the_table_names_every_method_in_order_and_says_a_line_about_it():
    assert list(all_methods()) == [*BASELINES, "two_stage", "two_imager", "disparity_spline"]
    assert all(method.about and "\n" not in method.about for method in all_methods().values())


@pytest.fixture(scope="module")
def judged():
    """Systematic error [mm] at 0.62-0.88 m on a simulated unit in the paper's range."""
    unit = SimulatedUnit(1, find_preset("paper"), 640, 360)
    views, _ = unit.calibration_views(Recording(poses=18))
    surfaces = [wall(0.62, 0.2, -0.1), wall(0.75, -0.1, 0.2), wall(0.88, 0.1, 0.1)]
    result = {}
    for name in (*BASELINES, "two_stage"):
        fitted = all_methods()[name].fit(views, unit.factory)
        errors = [
            fitted.apply(unit.clean(unit.truth(surface))) - unit.expected(surface, fitted.T_colour_depth)
            for surface in surfaces
        ]
        result[name] = 1e3 * float(np.mean([np.nanmean(np.abs(error)) for error in errors]))
    return result


def test_each_step_of_modelling_pays(judged):
    assert 14.0 < judged["none"] < 24.0
    assert judged["tare"] < 0.3 * judged["none"]
    assert judged["global_quadratic"] < judged["tare"]
    assert judged["clams"] < judged["tare"]
    assert max(judged[name] for name in ("herrera", "basso")) < 0.8 * judged["global_quadratic"]


def test_the_joint_methods_reach_what_is_known_of_them(judged):
    assert max(judged[name] for name in JOINT) < 1.111  # [mm], the figure of the paper
    assert max(judged["herrera"], judged["basso"]) < 0.6
