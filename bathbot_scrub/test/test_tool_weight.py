"""The weight of the tool, found from postures and taken off the force."""

import numpy as np
import pytest
from bathbot_scrub.arm.errors import InvalidPoseError
from bathbot_scrub.rm65.force.tool_weight import ToolWeight, estimate
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

rotations = st.integers(0, 10_000).map(lambda seed: Rotation.random(6, rng=seed).as_matrix())
centres = st.tuples(*[st.floats(-0.1, 0.1)] * 3)


@given(rotations=rotations, mass=st.floats(0.05, 2.0), centre=centres, seed=st.integers(0, 99))
def test_the_weight_is_found_from_postures_whatever_the_bias(rotations, mass, centre, seed):
    tool = ToolWeight(mass, np.array(centre))
    bias = np.random.default_rng(seed).normal(0.0, 3.0, 6)
    found = estimate(rotations, tool.pull(rotations) + bias)
    assert_allclose(found.mass, mass, atol=1e-9)
    assert_allclose(found.centre, centre, atol=1e-8)
    # what is left after zeroing at one posture does not change with the posture any more
    left = tool.pull(rotations) - (found.pull(rotations) - found.pull(rotations[0]))
    assert_allclose(left, np.tile(tool.pull(rotations[0]), (len(rotations), 1)), atol=1e-8)


def test_weight_by_hand_upright_and_on_its_side():
    tool = ToolWeight(0.5, np.array([0.0, 0.0, 0.05]))
    assert_allclose(tool.pull(np.eye(3)), [0.0, 0.0, -4.903325, 0.0, 0.0, 0.0])
    side = Rotation.from_euler("x", 90, degrees=True).as_matrix()
    assert_allclose(tool.pull(side), [0.0, -4.903325, 0.0, 0.24516625, 0.0, 0.0], atol=1e-12)


def test_postures_that_do_not_turn_the_sensor_tell_no_weight():
    turned = Rotation.from_euler("z", [[0], [40], [80]], degrees=True).as_matrix()
    with pytest.raises(InvalidPoseError, match="three or more"):
        estimate(turned, np.zeros((3, 6)))
