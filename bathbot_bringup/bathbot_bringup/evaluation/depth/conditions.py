"""The default correction where the calibration did not look: other temperatures, wet skin, steam."""

import numpy as np

from bathbot_bringup.evaluation.depth.measures import Fitted, errors
from bathbot_bringup.evaluation.depth.simulated_unit import CELSIUS, SimulatedUnit
from bathbot_bringup.evaluation.depth.targets import wall
from bathbot_bringup.sim.camera.d455 import Air

DISTANCE = 0.75  # [m]
# Each: degrees from the calibration's temperature, and the air.
CONDITIONS = {
    "as calibrated": (0.0, Air()),
    "10 deg C colder": (-10.0, Air()),
    "10 deg C warmer": (10.0, Air()),
    "wet": (0.0, Air(wetness=1.0)),
    "steam": (0.0, Air(steam=1.0)),
    "drops on the window": (0.0, Air(drops=12)),
}


def condition_errors(unit: SimulatedUnit, correction: Fitted) -> dict[str, float]:
    """Mean absolute error [mm] of one frame of a wall, condition by condition.

    Pixels off by more than 20 mm are left out: wet surfaces give wrong matches, which no correction knows.
    """
    surface = wall(DISTANCE)
    truth, expected = unit.truth(surface), unit.expected(surface, correction.T_colour_depth)
    found = {}
    for name, (warmer, air) in CONDITIONS.items():
        depth = correction.apply(unit.frame(truth, 0, 150, CELSIUS + warmer, air))
        gross = np.abs(depth - expected) > 0.02
        found[name] = errors(np.where(gross, np.nan, depth), expected).absolute
    return found
