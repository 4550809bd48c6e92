"""Corners, colour reference, guards and report: what decides the absolute accuracy."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from bathbot_depthcorr.calibration.calibrate import calibrate
from bathbot_depthcorr.calibration.guards import CalibrationRefusedError, check_colour, check_extrinsics
from bathbot_depthcorr.calibration.plots import save_plots
from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import Plane
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_depthcorr.views.chessboard import (
    BoardNotFoundError,
    Chessboard,
    board_plane,
    board_pose,
    find_corners,
)
from bathbot_depthcorr.views.colour_reference import BoardView, measure_colour_camera, views_from_boards
from depthcorr_wall import Sensor, colour_camera
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

BOARD = Chessboard()
COLOUR = colour_camera(848, 480)
PLAIN = Pinhole(848, 480, 420.0, 420.0, 423.0, 240.0)


def placed(rng, distance, tilt):
    """Pose of the board's frame in the colour frame, its middle near the picture's."""
    turn = Rotation.from_euler("xyz", (*rng.uniform(-tilt, tilt, 2), rng.uniform(-0.2, 0.2))).as_matrix()
    middle = np.array([*rng.uniform(-0.08, 0.08, 2) * distance, distance])
    return transform_from(turn, middle - turn @ BOARD.corners.mean(axis=0))


def wall_of(pose):
    normal = -pose[:3, 2] * np.sign(pose[:3, 2] @ pose[:3, 3])
    return Plane(normal, float(normal @ pose[:3, 3]))


def board_views(sensor, rng, count, *, tilt=0.4, near=0.55, far=1.3, noise=0.06):
    views, walls = [], []
    for distance in 1.0 / np.linspace(1.0 / near, 1.0 / far, count):
        pose = placed(rng, distance, tilt)
        points = BOARD.corners @ pose[:3, :3].T + pose[:3, 3]
        corners = COLOUR.project(points) + rng.normal(0.0, noise, (len(points), 2))
        seen = sensor.view(wall_of(pose), rng, frames=2)
        views.append(BoardView(corners, seen.depth, seen.frames, seen.temporal_noise))
        walls.append(wall_of(pose))
    return views, walls


@pytest.fixture(scope="module")
def sensor():
    return Sensor(seed=3, width=424, height=240, least_depth=0.2)


@pytest.fixture(scope="module")
def boards(sensor):
    return board_views(sensor, np.random.default_rng(0), 18)[0]


def picture(pose, camera=PLAIN, supersampling=4):
    """A chessboard with a white margin, drawn by a homography with many samples per pixel."""
    big = camera.scaled(camera.width * supersampling, camera.height * supersampling)
    cells = np.add.outer(np.arange(BOARD.rows + 1), np.arange(BOARD.columns + 1)) % 2
    margin = np.pad(cells * 220 + 20, 1, constant_values=240).astype(np.uint8)
    scale = 40
    print_ = np.kron(margin, np.ones((scale, scale), np.uint8))
    metres = np.array(
        [
            [BOARD.square / scale, 0, -2 * BOARD.square],
            [0, BOARD.square / scale, -2 * BOARD.square],
            [0, 0, 1],
        ]
    )
    metres[:2, 2] += 0.5 * BOARD.square / scale
    warp = big.matrix @ pose[:3, [0, 1, 3]] @ metres
    drawn = cv2.warpPerspective(
        print_, warp, (big.width, big.height), flags=cv2.INTER_LINEAR, borderValue=120
    )
    return cv2.GaussianBlur(
        cv2.resize(drawn, (camera.width, camera.height), interpolation=cv2.INTER_AREA), (0, 0), 0.6
    )


@pytest.mark.parametrize("distance", [0.6, 0.9, 1.3])
def test_corners_of_a_drawn_board_are_unbiased(distance):
    rng = np.random.default_rng(int(10 * distance))
    left = []
    for _ in range(3):
        pose = placed(rng, distance, 0.35)
        truth = PLAIN.project(BOARD.corners @ pose[:3, :3].T + pose[:3, 3])
        noisy = picture(pose) + rng.normal(0.0, 1.0, (480, 848))
        found = find_corners(np.clip(noisy, 0, 255).astype(np.uint8), BOARD)
        left.append(min((found - truth, found[::-1] - truth), key=lambda error: np.abs(error).max()))
        grown = np.ptp(found, axis=0) / np.ptp(truth, axis=0)
        assert_allclose(grown, 1.0, atol=8e-4)
    assert np.sqrt(np.mean(np.square(left))) < 0.06


def test_a_hidden_corner_or_no_board_is_told():
    pose = placed(np.random.default_rng(1), 0.8, 0.2)
    covered = picture(pose)
    covered[:, :440] = 128
    for image in (covered, np.full((480, 848), 128, np.uint8)):
        with pytest.raises(BoardNotFoundError, match="no chessboard of 11x8 inner corners"):
            find_corners(image, BOARD)


@pytest.mark.parametrize("arguments", [(2, 8), (11, 8, 50.0), (11, 8, 0.0)])
def test_impossible_boards_are_refused(arguments):
    with pytest.raises(SettingsError, match=r"board must have|square must be"):
        Chessboard(*arguments)


def test_the_boards_plane_and_its_covariance():
    """Over many draws of corner noise the plane errs as its covariance says."""
    rng = np.random.default_rng(2)
    pose = placed(rng, 0.9, 0.3)
    truth = COLOUR.project(BOARD.corners @ pose[:3, :3].T + pose[:3, 3])
    errors, told = [], None
    for _ in range(150):
        found, residual = board_pose(truth + rng.normal(0.0, 0.2, truth.shape), BOARD, COLOUR)
        plane, told = board_plane(found, BOARD, COLOUR, 0.2)
        errors.append(plane.inverse_form - wall_of(pose).inverse_form)
        assert 0.1 < residual < 0.3
    assert_allclose(np.std(errors, axis=0), np.sqrt(np.diag(told)), rtol=0.25)


def test_a_wrong_factory_focal_length_is_found(boards):
    wrong = replace(COLOUR, fx=1.002 * COLOUR.fx, fy=1.002 * COLOUR.fy)
    found = measure_colour_camera([view.corners for view in boards], BOARD, wrong)
    assert abs(found.focal_change + 0.002) < 3.0 * found.focal_sigma
    assert abs(found.camera.fx / COLOUR.fx - 1.0) < 0.0008
    assert 0.04 < found.corner_noise < 0.08


def test_frontal_views_keep_the_factorys_focal_length(sensor):
    frontal, _ = board_views(sensor, np.random.default_rng(4), 10, tilt=0.01)
    wrong = replace(COLOUR, fx=1.001 * COLOUR.fx, fy=1.001 * COLOUR.fy)
    found = measure_colour_camera([view.corners for view in frontal], BOARD, wrong)
    assert found.focal_sigma > 0.002
    assert abs(found.camera.fx / wrong.fx - 1.0) < 0.0015


def test_squares_are_measured_by_the_default_model_whatever_is_fitted(sensor, boards):
    """The paper's two stages leave millimetres to the transform; that is no fault of the squares."""
    views, reference = views_from_boards(boards, BOARD, COLOUR)
    _, report = calibrate(views, sensor.factory, "two_stage", reference)
    assert not any("by the board" in warning for warning in report.warnings)
    wrong = Chessboard(square=0.047)
    views, reference = views_from_boards(boards, wrong, COLOUR)
    with pytest.raises(CalibrationRefusedError, match="--square"):
        calibrate(views, sensor.factory, "two_stage", reference)


def test_a_calibration_from_boards_reports_what_it_reached(sensor, boards, tmp_path):
    views, reference = views_from_boards(boards, BOARD, COLOUR)
    correction, report = calibrate(views, sensor.factory, reference=reference)
    assert correction.serial == "TEST-1"
    assert report.views == 18
    assert len(report.held_out) == 4
    assert report.before > 0.014
    assert report.after < 0.2 * report.before
    assert [view.distance for view in report.held_out] == sorted(view.distance for view in report.held_out)
    assert any(line.startswith("raw depth: ") for line in report.references())
    save_plots(report, tmp_path / "report.png")
    assert cv2.imread(str(tmp_path / "report.png")) is not None


class TestRefusals:
    def refused(self, views, unit, words, reference=None):
        with pytest.raises(CalibrationRefusedError, match=words) as caught:
            calibrate(views, unit, reference=reference)
        assert "\n" not in str(caught.value)

    def views(self, boards, board=BOARD):
        return views_from_boards(boards, board, COLOUR)[0]

    def test_too_few(self, sensor, boards):
        self.refused(self.views(boards[:6]), sensor.factory, "6 usable views of the wall, at least 10")

    def test_too_similar(self, sensor, boards):
        self.refused(self.views(boards)[:3] * 5, sensor.factory, "only 3 of 15 views differ")

    def test_frontal_only(self, sensor):
        frontal, _ = board_views(sensor, np.random.default_rng(5), 12, tilt=0.05)
        self.refused(self.views(frontal), sensor.factory, "0% of the views are tilted by 8 deg")

    def test_one_distance(self, sensor):
        near, _ = board_views(sensor, np.random.default_rng(6), 12, near=0.7, far=0.8)
        self.refused(self.views(near), sensor.factory, r"distances span 0\.70 to 0\.8\d m")

    def test_wrong_square(self, sensor, boards):
        self.refused(
            self.views(boards, Chessboard(square=0.045)),
            sensor.factory,
            r"raw depth is 1\.1\d\d times .*--square",
        )

    def test_mirrored_picture(self, sensor, boards):
        mirrored = [view._replace(corners=view.corners * (-1, 1) + (847, 0)) for view in boards]
        self.refused(self.views(mirrored), sensor.factory, "turned by .* deg against the board.*mirrored")

    @pytest.mark.parametrize(("turn", "move"), [(0.03, 0.0), (0.0, 0.02)])
    def test_transform_far_from_the_factorys(self, sensor, turn, move):
        change = transform_from(Rotation.from_rotvec((0.0, turn, 0.0)).as_matrix(), (0.0, 0.0, move))
        moved = replace(sensor.factory, T_colour_depth=change @ sensor.factory.T_colour_depth)
        assert check_extrinsics(sensor.factory, sensor.factory) == []
        with pytest.raises(CalibrationRefusedError, match=r"are the topics of one camera\?"):
            check_extrinsics(moved, sensor.factory)

    def test_focal_length_far_off(self, boards):
        wrong = replace(COLOUR, fx=1.02 * COLOUR.fx, fy=1.02 * COLOUR.fy)
        reference = measure_colour_camera([view.corners for view in boards], BOARD, wrong)
        with pytest.raises(CalibrationRefusedError, match=r"differs by -2\.\d\d% from the factory's"):
            check_colour(reference)

    def test_moving_camera_or_bent_board(self, boards):
        rng = np.random.default_rng(7)
        shaken = [view.corners + rng.normal(0.0, 2.0, view.corners.shape) for view in boards]
        with pytest.raises(CalibrationRefusedError, match="corners miss the fitted board by"):
            check_colour(measure_colour_camera(shaken, BOARD, COLOUR))

    def test_unknown_model(self, sensor, boards):
        with pytest.raises(SettingsError, match="unknown depth model 'magic'; known are disparity_spline"):
            calibrate(self.views(boards), sensor.factory, "magic")
