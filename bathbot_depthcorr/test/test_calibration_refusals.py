"""What a calibration refuses, leaves out or warns of: each with the number, and nothing written."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from bathbot_depthcorr.calibration.calibrate import calibrate, calibrate_bag, views_of_recording
from bathbot_depthcorr.calibration.guards import CalibrationRefusedError
from bathbot_depthcorr.calibration.wall_guards import compare_wall
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.views.bag_views import BagError, read_boards
from bathbot_depthcorr.views.chessboard import Chessboard
from bathbot_depthcorr.views.views import nearest_first
from depthcorr_bag import BOARD, PREFIX, record
from depthcorr_wall import Sensor


@pytest.fixture(scope="module")
def sensor():
    return Sensor(seed=2, width=424, height=240, least_depth=0.2)


@pytest.fixture(scope="module")
def bag(tmp_path_factory, sensor):
    """Fourteen poses; the factory's transform is right, so that only what a test breaks is wrong."""
    path = tmp_path_factory.mktemp("bags") / "wall"
    record(path, sensor, 14, transform=sensor.T_colour_depth)
    return path


@pytest.fixture(scope="module")
def recording(bag):
    return read_boards(bag, BOARD)


@pytest.fixture
def refused(tmp_path):
    """Ask for a calibration that must be refused in one line, with nothing written."""

    def ask(kind, words, bag, **options):
        with pytest.raises(kind, match=words) as caught:
            calibrate_bag(bag, tmp_path / "unit.npz", **options)
        assert "\n" not in str(caught.value)
        assert isinstance(caught.value, BathbotError)
        assert not list(tmp_path.glob("unit*"))

    return ask


def fitted_with(recording, square):
    found = views_of_recording(recording, Chessboard(square=square))
    return calibrate(found.views, found.unit, reference=found.reference)[1]


@pytest.fixture(scope="module")
def fitted(recording):
    """The report of a calibration with nothing wrong."""
    return fitted_with(recording, 0.05)


def raw_depth(recording):
    """Scale and shift [px] of raw depth, which need no fit of a model."""
    found = views_of_recording(recording, BOARD)
    return compare_wall(nearest_first(found.views), found.unit)


@pytest.mark.parametrize(("square", "words"), [
    pytest.param(0.045, r"raw depth is 1\.1\d\d times", id="a tenth too small"),
    pytest.param(0.0475, r"raw depth is 1\.0[67]\d times", id="5 % too small"),
    pytest.param(0.0532, r"imager are 6\d\.\d mm apart by the board, .* \+[56]\.\d%", id="6 % too large"),
])  # fmt: skip
def test_a_wrong_square(recording, square, words):
    with pytest.raises(CalibrationRefusedError, match=words):
        fitted_with(recording, square)


def test_a_square_that_is_3_percent_too_large_is_warned_of(recording, fitted):
    """Raw depth alone would not tell: it errs by 1.2 % the other way. The distance of the imagers does."""
    right, wrong = fitted, fitted_with(recording, 0.0515)
    assert abs(right.raw.scale - 1.012) < 0.004
    assert wrong.raw.scale == pytest.approx(right.raw.scale / 1.03, abs=1e-3)
    assert not any("raw depth" in warning for warning in wrong.warnings)
    assert any("apart by the board" in warning for warning in wrong.warnings)
    assert not any("apart by the board" in warning for warning in right.warnings)


def test_a_shift_of_disparity_is_no_wrong_square(recording):
    """Depth that is 9 % too far at 1.1 m by 2 px of disparity still has the right scale near the camera."""
    unit = recording.unit
    boards = [
        seen._replace(
            depth=(unit.focal_baseline / (unit.focal_baseline / seen.depth - 2.0)).astype(np.float32)
        )
        for seen in recording.boards
    ]
    before, after = raw_depth(recording), raw_depth(recording._replace(boards=boards))
    assert after.scale == pytest.approx(before.scale, abs=3e-3)
    assert after.shift == pytest.approx(before.shift - 2.0, abs=0.05)


def test_a_mirrored_picture(sensor, refused, tmp_path):
    record(tmp_path / "bag", sensor, 11, paint=lambda colour, *_: colour[:, ::-1])
    refused(CalibrationRefusedError, "turned by .* deg against the board.*mirrored", tmp_path / "bag")


def test_a_moving_camera(sensor, refused, tmp_path):
    record(tmp_path / "bag", sensor, 3, paint=lambda colour, _, number: np.roll(colour, 17 * number, axis=1))
    refused(BagError, "shows no 11x8 board in 0 still poses; hold the camera still", tmp_path / "bag")


def test_hidden_and_blurred_boards_are_left_out_and_counted(sensor, tmp_path):
    def spoil(colour, pose, _):
        if pose < 2:
            colour[:, :320] = 90
        return cv2.blur(colour, (9, 1)) if pose == 2 else colour

    record(tmp_path / "bag", sensor, 5, paint=spoil)
    recording = read_boards(tmp_path / "bag", BOARD)
    assert len(recording.boards) == 2
    assert recording.notes == [
        "2 still poses without the board were left out", "1 still poses blurred were left out"
    ]  # fmt: skip


def test_every_board_hidden_or_blurred(sensor, refused, tmp_path):
    def hide(colour, *_):
        colour[:, :320] = 90
        return colour

    record(tmp_path / "hidden", sensor, 1, paint=hide)
    refused(BagError, "shows no 11x8 board in 1 still poses", tmp_path / "hidden")
    record(tmp_path / "blurred", sensor, 2, paint=lambda colour, *_: cv2.blur(colour, (1, 9)))
    refused(BagError, "board blurred in all 2 poses that have it: edges wider than 4", tmp_path / "blurred")


def test_glare_holes_leave_the_wall_around_them(recording, fitted):
    """A hole of a quarter of the picture in every view costs no more than twice the error."""
    holed = []
    for number, seen in enumerate(recording.boards):
        depth, u = seen.depth.copy(), 60 + 15 * (number % 8)
        depth[50:190, u : u + 180] = np.nan
        holed.append(seen._replace(depth=depth))
    rest = fitted_with(recording._replace(boards=holed), 0.05)
    assert rest.views == 14
    assert rest.after < 2.0 * fitted.after < 0.4 * rest.before


def test_too_little_wall_in_too_many_views(sensor, refused, tmp_path):
    record(tmp_path / "bag", sensor, 12, hide=lambda mm, pose: mm * (np.arange(424) > 360 * (pose % 2)))
    refused(
        CalibrationRefusedError,
        r"on 20% or more of the picture in only 6 of 12 views, the worst has 1\d%; at least 10",
        tmp_path / "bag",
    )


def test_no_depth_at_all(sensor, refused, tmp_path):
    record(tmp_path / "bag", sensor, 2, hide=lambda mm, _: 0 * mm)
    refused(CalibrationRefusedError, "in only 0 of 2 views, the worst has 0%", tmp_path / "bag")


def test_a_size_that_changes(sensor, refused, tmp_path):
    record(tmp_path / "depth", sensor, 2, hide=lambda mm, pose: mm[: 240 - 40 * pose])
    refused(BagError, "a depth picture has 424x200 px, its camera_info says 424x240", tmp_path / "depth")
    record(tmp_path / "colour", sensor, 2, paint=lambda colour, pose, _: colour[:, : 640 - 80 * pose])
    refused(BagError, "a colour picture has 560x360 px, its camera_info says 640x360", tmp_path / "colour")


def test_colour_and_depth_of_two_cameras(sensor, refused, tmp_path):
    names = ("depth/image_rect_raw", "depth/camera_info")
    record(tmp_path / "bag", sensor, 1, rename={name: f"/left/{name}" for name in names})
    refused(BagError, f"are of 2 cameras, {PREFIX}, /left; record one", tmp_path / "bag")


def test_diagnostics_of_two_cameras(sensor, refused, tmp_path):
    record(tmp_path / "one", sensor, 1, serials=("123", "123"))
    assert read_boards(tmp_path / "one", BOARD).unit.serial == "123"
    record(tmp_path / "two", sensor, 1, serials=("123", "456"))
    refused(BagError, "diagnostics of 2 cameras, 123, 456", tmp_path / "two")


@pytest.mark.parametrize(("entry", "words"), [
    pytest.param((0, 3), "put depth and colour nan m apart", id="nan"),
    pytest.param((1, 1), "extrinsics hold no rotation", id="no rotation"),
])  # fmt: skip
def test_broken_extrinsics(sensor, refused, tmp_path, entry, words):
    broken = sensor.factory.T_colour_depth.copy()
    broken[entry] = np.nan
    record(tmp_path / "bag", sensor, 1, transform=broken)
    refused(BathbotError, words, tmp_path / "bag")


def test_a_transform_of_another_camera(recording):
    other = recording.unit.T_colour_depth.copy()
    other[0, 3] += 0.03
    unit = replace(recording.unit, T_colour_depth=other)
    with pytest.raises(CalibrationRefusedError, match=r"mm off the factory's .*topics of one camera"):
        fitted_with(recording._replace(unit=unit), 0.05)
