"""Scenes for calibration: what is printed is found where it is."""

import cv2
import numpy as np
import pytest
from bathbot_bringup.sim.camera.calibration_scene import (
    INNER_CORNERS,
    MARKER_ID,
    MARKER_SIZE,
    SQUARE,
    ChessboardView,
    MarkerView,
    board_views,
)
from bathbot_bringup.sim.camera.d455_unit import PRESETS, make_unit
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from bathbot_scrub.rm65.arm.rm65 import RM65
from numpy.testing import assert_allclose
from scene_reach import head_poses

UNIT = make_unit(1, PRESETS["paper"], 848, 480)


@pytest.fixture(scope="module")
def chessboard() -> ChessboardView:
    return ChessboardView(UNIT, count=24, hold=1.0, seed=0)


def board_points() -> np.ndarray:
    columns, rows = INNER_CORNERS
    x, y = np.meshgrid(
        (np.arange(columns) - (columns - 1) / 2) * SQUARE, (np.arange(rows) - (rows - 1) / 2) * SQUARE
    )
    return np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)


@pytest.mark.parametrize("pose", [0, 12, 23])
def test_corners_are_found_within_a_tenth_of_a_pixel(chessboard, pose):
    grey = cv2.cvtColor(chessboard.frame(pose + 0.5).colour, cv2.COLOR_RGB2GRAY)
    found, corners = cv2.findChessboardCornersSB(grey, INNER_CORNERS)
    assert found
    corners = cv2.cornerSubPix(grey, corners, (5, 5), (-1, -1), (3, 40, 1e-4)).reshape(-1, 2)
    expected = UNIT.colour.project(transform_points(inverse(chessboard.T_board_colour(pose)), board_points()))
    if np.abs(corners - expected).max() > 5.0:  # the finder may begin at the other end
        corners = corners[::-1]
    assert np.sqrt(np.mean((corners - expected) ** 2)) < 0.1


def test_depth_is_the_wall(chessboard):
    frame = chessboard.frame(10.5)
    rays = UNIT.depth.directions(UNIT.depth.pixel_grid())
    T_board_depth = chessboard.T_board_colour(10) @ UNIT.T_colour_depth
    points = transform_points(T_board_depth, rays * frame.depth[..., None])
    on_the_wall = np.abs(points[..., 0]) < 0.35
    assert np.abs(points[on_the_wall][:, 2]).max() < 1e-4


def test_poses_hold_still_and_step(chessboard):
    assert chessboard.pose_number(0.0) == chessboard.pose_number(0.99) == 0
    assert chessboard.pose_number(1.0) == 1
    assert chessboard.pose_number(1e6) == 23
    assert chessboard.frame(3.1).pose == 3


def test_poses_are_near_and_far_tilted_and_all_over_the_picture():
    views = board_views(UNIT.colour, 30, seed=4)
    distances = np.array([inverse(view)[2, 3] for view in views])
    tilts = np.array([np.rad2deg(np.arccos(view[2, 2])) for view in views])
    centres = np.array([UNIT.colour.project(inverse(view)[:3, 3]) for view in views])
    assert distances.min() < 0.5
    assert distances.max() > 1.4
    assert (tilts > 12.0).mean() > 0.5
    assert np.ptp(centres[:, 0]) > 400
    assert np.ptp(centres[:, 1]) > 150


def test_the_marker_is_found_where_the_flange_carries_it():
    view = MarkerView(UNIT, sensor_seed=1)
    eye = view.truth.T_base_camera[:3, 3]
    rng = np.random.default_rng(0)
    points = rng.uniform((0.2, -0.1, 0.1), (0.4, 0.25, 0.35), (300, 3))
    towards = eye - points + rng.normal(0.0, 0.3, points.shape)
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    solutions = RM65().solve_head(head_poses(points, -towards))
    joints = solutions[np.isfinite(solutions).all(axis=-1)][0]
    frame = view.frame(0.0, joints)
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_ARUCO_ORIGINAL))
    corners, ids, _ = detector.detectMarkers(cv2.cvtColor(frame.colour, cv2.COLOR_RGB2GRAY))
    assert ids is not None
    assert MARKER_ID in ids
    half = MARKER_SIZE / 2
    printed = np.array([(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)])
    T_base_marker = RM65().flange(joints) @ view.truth.T_flange_marker
    T_colour_base = UNIT.T_colour_depth @ inverse(view.truth.T_base_camera)
    expected = UNIT.colour.project(transform_points(T_colour_base @ T_base_marker, printed))
    assert_allclose(corners[0].reshape(4, 2), expected, atol=1.5)
    centre = transform_points(inverse(view.truth.T_base_camera) @ T_base_marker, np.zeros(3))
    u, v = np.round(UNIT.depth.project(centre)).astype(int)
    assert_allclose(frame.depth[v, u], centre[2], atol=2e-3)
