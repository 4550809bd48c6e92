"""Poses of contact targets, their covariance, and the error of Eq. (19)."""

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import rotate, transform_from, transform_points
from bathbot_localize.surface.surface_fit import fit_surface
from bathbot_localize.target.target import axis_errors, localization_error, pose_from_normal, target_from_fit
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from localize_scene import COLOUR, FB, T_BASE_COLOUR
from scipy.spatial.transform import Rotation

UNIT = (
    st.tuples(*[st.floats(-1.0, 1.0)] * 3)
    .filter(lambda v: np.linalg.norm(v) > 0.1)
    .map(lambda v: np.array(v) / np.linalg.norm(v))
)


@settings(max_examples=200, deadline=None)
@given(normal=UNIT)
def test_the_pose_is_right_handed_with_z_into_the_skin(normal):
    pose = pose_from_normal((0.4, 0.1, 0.2), normal)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(pose[:3, :3].T @ pose[:3, :3], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose[:3, 2], -normal, atol=1e-12)
    np.testing.assert_allclose(np.cross(pose[:3, 1], pose[:3, 2]), pose[:3, 0], atol=1e-12)
    np.testing.assert_allclose(pose[:3, 3], (0.4, 0.1, 0.2))


@settings(max_examples=50, deadline=None)
@given(normal=UNIT, turn=st.floats(-3.0, 3.0))
def test_the_pose_turns_with_the_skin_about_the_vertical(normal, turn):
    """y is made from base z, so a turn about it turns the whole pose (where the skin does not lie flat)."""
    assume(abs(normal[2]) < 0.88)
    move = transform_from(Rotation.from_rotvec([0.0, 0.0, turn]).as_matrix(), (0.1, 0.2, 0.3))
    expected = move @ pose_from_normal((0.4, 0.1, 0.2), normal)
    np.testing.assert_allclose(pose_from_normal(expected[:3, 3], rotate(move, normal)), expected, atol=1e-9)


def test_a_chest_that_faces_the_base_by_hand():
    """Normal towards -x: the head points along +x and travels up; its x is z_base cross x_base = y_base."""
    pose = pose_from_normal((0.5, 0.0, 0.3), (-1.0, 0.0, 0.0))
    np.testing.assert_allclose(pose[:3, :3], [[0, 0, 1], [1, 0, 0], [0, 1, 0]], atol=1e-12)


def test_a_thigh_that_lies_flat_by_hand():
    """Normal up: the head points down and travels outward; its x is x_base cross -z_base = y_base."""
    pose = pose_from_normal((0.5, 0.0, 0.0), (0.0, 0.0, 1.0))
    np.testing.assert_allclose(pose[:3, :3], [[0, 1, 0], [1, 0, 0], [0, 0, -1]], atol=1e-12)


def fits(count, rng):
    """Fits of a tilted plane on the axis at 0.7 m, with disparity noise of 0.07 px."""
    u, v = np.meshgrid(np.arange(-10, 11), np.arange(-10, 11))
    rays = np.stack([u / COLOUR.fx, v / COLOUR.fy, np.ones_like(u)], axis=-1).reshape(-1, 3)
    depth = 0.7 / (1.0 + 0.5 * rays[:, 0] - 0.3 * rays[:, 1])
    for _ in range(count):
        noisy = FB / (FB / depth + rng.normal(0.0, 0.07, depth.shape))
        yield fit_surface(rays * noisy[:, None], (0.0, 0.0, 1.0), 10.0)


def test_the_covariance_of_the_pose_is_what_a_monte_carlo_run_shows():
    targets = [
        target_from_fit("Trunk_skin", 0.9, fit, T_BASE_COLOUR, (0.0, 0.0))
        for fit in fits(400, np.random.default_rng(0))
    ]
    centre = targets[0].T_base_target
    errors = np.stack([
        np.r_[
            target.T_base_target[:3, 3] - centre[:3, 3],
            Rotation.from_matrix(target.T_base_target[:3, :3] @ centre[:3, :3].T).as_rotvec(),
        ]
        for target in targets
    ])  # fmt: skip
    spread = np.cov(errors.T)
    told = np.mean([target.covariance for target in targets], axis=0)
    assert np.diag(told) == pytest.approx(np.diag(spread), rel=0.3)
    assert np.abs(told - spread).max() < 0.3 * np.abs(spread).max()


def test_covariance_is_symmetric_and_not_negative():
    target = target_from_fit(
        "a", 1.0, next(fits(1, np.random.default_rng(1))), T_BASE_COLOUR, (0.0, 0.0), 0.001
    )
    np.testing.assert_allclose(target.covariance, target.covariance.T)
    assert np.linalg.eigvalsh(target.covariance).min() > -1e-12
    assert np.diag(target.covariance)[:3].min() >= 1e-6


def test_a_rigid_motion_of_the_camera_moves_position_and_normal():
    fit = next(fits(1, np.random.default_rng(2)))
    move = transform_from(Rotation.from_rotvec([0.2, -0.1, 0.5]).as_matrix(), (0.1, 0.2, -0.1))
    here = target_from_fit("a", 1.0, fit, T_BASE_COLOUR, (0.0, 0.0)).T_base_target
    there = target_from_fit("a", 1.0, fit, move @ T_BASE_COLOUR, (0.0, 0.0)).T_base_target
    np.testing.assert_allclose(there[:3, 3], transform_points(move, here[:3, 3]), atol=1e-12)
    np.testing.assert_allclose(there[:3, 2], rotate(move, here[:3, 2]), atol=1e-12)


def test_localization_error_of_the_papers_first_row():
    """Table 2, number 1: 2.128 mm from axis errors 1.11, 1.08 and 1.46 mm."""
    theoretical, actual = np.array([251.04, 375.06, 763.69]) * 1e-3, np.array([252.15, 376.14, 765.15]) * 1e-3
    np.testing.assert_allclose(axis_errors(theoretical, actual) * 1e3, [1.11, 1.08, 1.46], atol=1e-9)
    assert localization_error(theoretical, actual) * 1e3 == pytest.approx(2.128, abs=0.001)


def test_localization_error_broadcasts():
    assert localization_error(np.zeros((4, 5, 3)), np.array([3.0, 4.0, 0.0])).shape == (4, 5)
