"""What the arm feels, from samples: the force begins anew when the sensor is zeroed."""

import numpy as np
import pytest
from bathbot_scrub.rm65.controller.state_push import ArmSample
from bathbot_scrub.rm65.motion.arm_senses import ArmSenses
from bathbot_scrub.rm65.settings import DriverSettings
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

CYCLE = 0.005  # [s]
PRESSED = np.array([0.0, 0.0, 4.0, 0.0, 0.0, 0.0])


def sample(stamp, wrench, rotation=None):
    T = np.eye(4)
    T[:3, :3] = np.eye(3) if rotation is None else rotation
    return ArmSample(stamp, np.zeros(6), np.zeros(6), np.asarray(wrench), T, (), (), "")


def test_zeroed_it_forgets_what_was_felt_before():
    """Else the filter would show the old force fading, and the lines through it a force that falls."""
    senses = ArmSenses(DriverSettings())
    for step in range(20):
        senses.take(sample(step * CYCLE, PRESSED))
    assert senses.wrench.filtered[2] == pytest.approx(4.0)
    assert senses.wrench.trends
    senses.begin_anew()
    senses.take(sample(20 * CYCLE, np.zeros(6)))
    assert_allclose(senses.wrench.filtered, 0.0, atol=1e-12)
    assert senses.wrench.trends == ()


def test_what_the_controller_leaves_of_the_tools_weight_is_gone_in_every_posture():
    mass, centre = 0.4, (0.0, 0.01, 0.05)
    senses = ArmSenses(DriverSettings(tool_mass=mass, tool_centre=centre))
    zeroed = Rotation.from_euler("xyz", [0.3, -0.2, 1.0]).as_matrix()

    def left(rotation):
        """By hand: the change of m [R^T g; c x R^T g] since the zeroing."""
        pull = mass * (rotation.T - zeroed.T) @ [0.0, 0.0, -9.80665]
        return np.concatenate([pull, np.cross(centre, pull)])

    senses.take(sample(0.0, left(zeroed), zeroed))
    senses.begin_anew()
    for step, rotation in enumerate(Rotation.random(20, rng=3).as_matrix()):
        senses.take(sample(0.1 * (step + 1), left(rotation), rotation))
        assert_allclose(senses.wrench.raw, 0.0, atol=1e-9)
