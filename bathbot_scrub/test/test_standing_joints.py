"""Where a motion begins: at the command while the arm catches up, at the measurement when it is astray."""

import math

import numpy as np
import pytest
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.rm65.motion.commanded_motion import standing_joints
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

COMMAND = np.array([0.2, 0.0, -2.0, -1.3, -0.3, -6.2])
NOT_YET = np.full(6, np.nan)


@given(st.floats(-0.3, 0.3), st.floats(0.0, 0.19), st.integers(0, 5))
def test_an_arm_that_moves_or_has_just_come_to_rest_only_lags(lag, rest, joint):
    assert_array_equal(standing_joints(COMMAND, COMMAND + lag * np.eye(6)[joint], rest), COMMAND)


@given(st.floats(0.031, 3.0), st.floats(0.21, math.inf), st.sampled_from([-1, 1]))
def test_an_arm_that_stands_elsewhere_is_there(away, rest, sign):
    measured = COMMAND + sign * away
    assert_array_equal(standing_joints(COMMAND, measured, rest), measured)


@given(st.floats(-0.029, 0.029), st.floats(0.0, math.inf))
def test_sag_and_noise_do_not_creep_into_the_command(away, rest):
    assert_array_equal(standing_joints(COMMAND, COMMAND + away, rest), COMMAND)


def test_without_a_command_the_measurement_counts_and_without_both_nothing():
    assert_array_equal(standing_joints(None, COMMAND, 0.0), COMMAND)
    with pytest.raises(NotReadyError, match="no state"):
        standing_joints(None, NOT_YET, math.inf)
    with pytest.raises(NotReadyError, match="no state"):
        standing_joints(COMMAND, NOT_YET, 1.0)
