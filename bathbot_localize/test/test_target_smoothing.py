"""The running mean lowers the noise of a body at rest and does not drag behind one that moves."""

import numpy as np
import pytest
from bathbot_localize.target.smoothing import TargetSmoother
from bathbot_localize.target.target import Target, pose_from_normal

SIGMA = 0.0003
NOISE = np.eye(3) * SIGMA**2


def target_at(position, pixel=(200.0, 100.0)):
    return Target(
        "Trunk_skin",
        0.9,
        pose_from_normal(position, (-1.0, 0.0, 0.0)),
        np.eye(6) * SIGMA**2,
        pixel,
        20.0,
        900,
    )


def test_noise_of_a_body_at_rest_is_lowered():
    rng, smoother, means = np.random.default_rng(0), TargetSmoother(5), []
    for index in range(400):
        position = np.array([0.5, 0.0, 0.2]) + rng.normal(0.0, SIGMA, 3)
        means.append(smoother.update(target_at(position), 0.1 * index, NOISE).T_base_target[:3, 3])
    assert np.std(np.array(means)[5:, 0]) < 0.65 * SIGMA


def test_one_frame_is_left_as_it_is():
    target = target_at((0.5, 0.0, 0.2))
    assert TargetSmoother(5).update(target, 0.0, NOISE) == target


def test_a_chest_that_breathes_is_not_followed_late():
    """8 mm/s, ten frames a second: a plain mean over five frames would lag 1.6 mm."""
    smoother, worst = TargetSmoother(5), 0.0
    for index in range(50):
        x = 0.5 + 0.008 * 0.1 * index
        mean = smoother.update(target_at((x, 0.0, 0.2)), 0.1 * index, NOISE)
        worst = max(worst, abs(mean.T_base_target[0, 3] - x))
    assert worst <= 0.0008


def test_a_target_elsewhere_starts_again():
    smoother = TargetSmoother(5)
    smoother.update(target_at((0.5, 0.0, 0.2)), 0.0, NOISE)
    moved = smoother.update(target_at((0.5, 0.03, 0.2), pixel=(230.0, 100.0)), 0.1, NOISE)
    assert moved.T_base_target[1, 3] == pytest.approx(0.03)


def test_old_frames_are_forgotten_and_time_may_jump_back():
    smoother = TargetSmoother(5)
    smoother.update(target_at((0.5, 0.0, 0.2)), 10.0, NOISE)
    for stamp in (20.0, 1.0):
        assert smoother.update(target_at((0.5002, 0.0, 0.2)), stamp, NOISE).T_base_target[
            0, 3
        ] == pytest.approx(0.5002)


def test_the_pixel_moves_with_the_mean():
    smoother = TargetSmoother(5)
    smoother.update(target_at((0.5, 0.0, 0.2), pixel=(200.0, 100.0)), 0.0, NOISE)
    mean = smoother.update(target_at((0.5, 0.002, 0.2), pixel=(204.0, 100.0)), 0.1, NOISE)
    assert mean.pixel == (202.0, 100.0)
    assert mean.T_base_target[1, 3] == pytest.approx(0.001)
    assert np.trace(mean.covariance) < 6 * SIGMA**2
