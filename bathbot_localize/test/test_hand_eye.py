"""Hand-eye calibration against known truth: noise, outliers, and views that must be refused."""

import cv2
import numpy as np
import pytest
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, rotation_angle, transform_from, transform_points
from bathbot_localize.hand_eye.marker import (
    MARKER_SIZE,
    MarkerNotFoundError,
    find_marker,
    marker_corners,
    marker_poses,
)
from bathbot_localize.hand_eye.solver import (
    HandEyeError,
    MarkerView,
    closed_forms,
    reprojection,
    rms,
    rotation_spread,
    solve_hand_eye,
)
from hand_eye_scene import CAMERA, T_BASE_CAMERA, T_TOOL_MARKER, arm_poses, draw_marker, marker_view
from scipy.spatial.transform import Rotation


def views_of(count, rng, noise=0.0):
    return [marker_view(pose, rng, noise) for pose in arm_poses(count, rng)]


def apart(first, second):
    """Distance [m] and angle [rad] between two transforms."""
    change = inverse(first) @ second
    return float(np.linalg.norm(first[:3, 3] - second[:3, 3])), float(rotation_angle(change[:3, :3]))


def test_perfect_views_give_the_truth():
    report = solve_hand_eye(views_of(10, np.random.default_rng(0)), CAMERA)
    distance, angle = apart(report.hand_eye.T_base_camera, T_BASE_CAMERA)
    assert distance < 1e-6
    assert angle < 1e-6
    assert apart(report.T_tool_marker, T_TOOL_MARKER)[0] < 1e-6
    assert report.hand_eye.residual_px < 1e-4
    assert report.hand_eye.poses == 10


def test_the_closed_forms_agree_on_perfect_views():
    views = views_of(10, np.random.default_rng(1))
    guesses = closed_forms(views, CAMERA, MARKER_SIZE)
    assert {"tsai", "park", "horaud", "daniilidis", "shah", "li"} <= set(guesses)
    for name in ("tsai", "park", "horaud", "daniilidis", "shah", "li"):
        assert apart(guesses[name][0], T_BASE_CAMERA)[0] < 1e-3, name


@pytest.mark.parametrize("seed", range(4))
def test_noisy_corners_give_the_camera_to_a_millimetre(seed):
    report = solve_hand_eye(views_of(15, np.random.default_rng(seed), noise=0.15), CAMERA)
    distance, angle = apart(report.hand_eye.T_base_camera, T_BASE_CAMERA)
    assert distance < 0.0025
    assert angle < np.radians(0.25)
    assert distance < 5.0 * np.linalg.norm(report.position_std)
    assert 0.08 < report.hand_eye.residual_px < 0.3


def test_refinement_beats_every_closed_form():
    views = views_of(15, np.random.default_rng(5), noise=0.2)
    report = solve_hand_eye(views, CAMERA)
    assert report.hand_eye.residual_px <= min(report.methods.values()) + 1e-9
    assert rms(
        reprojection(report.hand_eye.T_base_camera, report.T_tool_marker, views, CAMERA, MARKER_SIZE)
    ) == (pytest.approx(report.hand_eye.residual_px))


def test_a_view_from_a_moving_arm_is_dropped():
    rng = np.random.default_rng(6)
    views = views_of(14, rng, noise=0.1)
    views[3] = MarkerView(
        views[3].T_base_tool @ transform_from(translation=(0.03, 0.0, 0.0)), views[3].corners
    )
    report = solve_hand_eye(views, CAMERA)
    assert report.dropped == 1
    assert apart(report.hand_eye.T_base_camera, T_BASE_CAMERA)[0] < 0.003


def test_the_result_does_not_depend_on_the_base_frame():
    """Moving the base moves the camera's pose in it, and nothing else."""
    rng = np.random.default_rng(7)
    views = views_of(10, rng, noise=0.1)
    T_new_old = transform_from(Rotation.from_rotvec([0.3, -0.2, 1.0]).as_matrix(), (0.4, -0.1, 0.2))
    moved = [MarkerView(T_new_old @ view.T_base_tool, view.corners) for view in views]
    first, second = solve_hand_eye(views, CAMERA), solve_hand_eye(moved, CAMERA)
    np.testing.assert_allclose(
        second.hand_eye.T_base_camera, T_new_old @ first.hand_eye.T_base_camera, atol=1e-5
    )


@pytest.mark.parametrize(("count", "message"), [(0, "0 still arm poses"), (7, "7 still arm poses")])
def test_few_poses_are_refused(count, message):
    with pytest.raises(HandEyeError, match=message):
        solve_hand_eye(views_of(max(count, 1), np.random.default_rng(0))[:count], CAMERA)


def test_turns_about_one_axis_only_are_refused():
    rng = np.random.default_rng(2)
    first = arm_poses(1, rng)[0]
    turned = [
        first @ transform_from(Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix())
        for angle in np.linspace(-0.5, 0.5, 10)
    ]
    assert rotation_spread(turned) < np.radians(1.0)
    with pytest.raises(HandEyeError, match="two different axes"):
        solve_hand_eye([marker_view(pose, rng) for pose in turned], CAMERA)


def test_views_that_contradict_each_other_are_refused():
    """Arm poses that belong to other pictures cannot be explained."""
    rng = np.random.default_rng(3)
    views = views_of(12, rng)
    shuffled = [
        MarkerView(a.T_base_tool, b.corners) for a, b in zip(views, views[5:] + views[:5], strict=True)
    ]
    with pytest.raises(HandEyeError):
        solve_hand_eye(shuffled, CAMERA)


def test_the_marker_is_found_where_it_was_drawn():
    rng = np.random.default_rng(4)
    for pose in arm_poses(6, rng):
        expected = marker_view(pose, rng).corners
        found = find_marker(draw_marker(pose, rng), CAMERA)
        assert np.abs(found - expected).max() < 0.12


def test_a_picture_without_the_marker_says_so():
    with pytest.raises(MarkerNotFoundError, match="markers in it: none"):
        find_marker(np.full((100, 100), 128, np.uint8), CAMERA)
    picture = draw_marker(arm_poses(1, np.random.default_rng(4))[0], np.random.default_rng(4), marker_id=17)
    with pytest.raises(MarkerNotFoundError, match="markers in it: 17"):
        find_marker(picture, CAMERA)


def test_marker_pose_by_hand():
    """A marker 0.5 m ahead, turned by 30 degrees about its upright middle: its right side comes nearer."""
    camera = Pinhole(640, 480, 500.0, 500.0, 320.0, 240.0)
    turn = Rotation.from_euler("y", 30, degrees=True).as_matrix()
    T_camera_marker = transform_from(turn @ np.diag([1.0, -1.0, -1.0]), (0.0, 0.0, 0.5))
    x, near, far = 0.05 * np.cos(np.pi / 6), 0.475, 0.525
    left, right = 320 - 500 * x / far, 320 + 500 * x / near
    corners = np.array([
        [left, 240 - 25 / far], [right, 240 - 25 / near], [right, 240 + 25 / near], [left, 240 + 25 / far],
    ])  # fmt: skip
    np.testing.assert_allclose(
        camera.project(transform_points(T_camera_marker, marker_corners(0.1))), corners
    )
    np.testing.assert_allclose(
        marker_poses(corners, camera, 0.1)[0].T_camera_marker, T_camera_marker, atol=1e-4
    )


def test_opencv_still_has_the_old_dictionary():
    assert cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_ARUCO_ORIGINAL).bytesList.shape[0] > 582
