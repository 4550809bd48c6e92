"""The measure of a stop, by hand."""

import numpy as np
from numpy.testing import assert_allclose
from stop_latency import latencies


def test_braking_begins_at_the_first_shorter_step_and_ends_with_the_last_that_moves():
    steps = np.array([0.0, 2.0, 2.0, 2.0, 2.0, 1.5, 1.0, 0.5, 0.0, 0.0]) * 1e-3
    stamps = 0.01 * np.arange(10)
    joints = np.tile(np.cumsum(steps)[:, None], (1, 6))
    assert_allclose(latencies(stamps, joints, [0.025])[0], [0.05 - 0.025, 0.07 - 0.025], atol=1e-9)


def test_an_arm_that_brakes_already_counts_as_at_once():
    steps = np.array([0.0, 2.0, 1.5, 1.0, 0.5, 0.0]) * 1e-3
    joints = np.tile(np.cumsum(steps)[:, None], (1, 6))
    begin, end = latencies(0.01 * np.arange(6), joints, [0.03])[0]
    assert_allclose((begin, end), (0.0, 0.01), atol=1e-9)
