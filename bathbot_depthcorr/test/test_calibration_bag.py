"""A calibration from a recorded bag, made and read without ROS."""

from types import SimpleNamespace

import numpy as np
import pytest
from bathbot_depthcorr.calibration.calibrate import calibrate_bag
from bathbot_depthcorr.calibration.guards import CalibrationRefusedError
from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.errors import BathbotError, SettingsError
from bathbot_depthcorr.files import CalibrationFileError
from bathbot_depthcorr.ros.camera_health import CameraHealth, camera_health
from bathbot_depthcorr.views.bag_views import BagError, read_boards
from bathbot_depthcorr.views.chessboard import Chessboard
from depthcorr_bag import BOARD, PREFIX, TYPES, record
from depthcorr_wall import Sensor


@pytest.fixture(scope="module")
def sensor():
    return Sensor(seed=2, width=424, height=240, least_depth=0.2)


@pytest.fixture(scope="module")
def bag(tmp_path_factory, sensor):
    path = tmp_path_factory.mktemp("bags") / "wall"
    record(path, sensor, 14)
    return path


def test_a_bag_becomes_a_calibration_with_picture_and_report(bag, sensor, tmp_path):
    told = []
    report = calibrate_bag(bag, tmp_path / "unit.npz", progress=told.append)
    assert report.views == 14
    assert report.after < 0.2 * report.before
    correction = load(tmp_path / "unit.npz")
    assert (correction.depth_camera.width, correction.depth_camera.fx) == (424, sensor.camera.fx)
    assert (tmp_path / "unit.png").stat().st_size > 10_000
    assert sum("board found" in line for line in told) == 14


def test_moving_frames_are_left_out(bag):
    recording = read_boards(bag, BOARD)
    assert len(recording.boards) == 14
    assert {board.frames for board in recording.boards} == {4}
    assert all(board.temporal_noise > 0.0 for board in recording.boards)
    centre = [float(np.nanmedian(board.depth[100:140, 190:230])) for board in recording.boards]
    assert max(centre) < 1.25  # while moving, the bag shows 1.3 times the distance


def refused(kind, words, call, *arguments, **keywords):
    with pytest.raises(kind, match=words) as caught:
        call(*arguments, **keywords)
    assert "\n" not in str(caught.value)
    assert isinstance(caught.value, BathbotError)


class TestBadBags:
    def test_missing_empty_or_foreign(self, tmp_path):
        refused(BagError, "cannot read bag .*absent", read_boards, tmp_path / "absent", BOARD)
        refused(BagError, "cannot read bag", read_boards, tmp_path, BOARD)
        (tmp_path / "notes.txt").write_text("no bag")
        refused(BagError, "cannot read bag", read_boards, tmp_path / "notes.txt", BOARD)

    @pytest.mark.parametrize("share", [0.3, 0.999])
    def test_cut_off(self, bag, tmp_path, share):
        target = tmp_path / "cut"
        target.mkdir()
        for file in bag.iterdir():
            data = file.read_bytes()
            (target / file.name).write_bytes(
                data[: int(share * len(data))] if file.suffix == ".mcap" else data
            )
        refused(BagError, "cannot read bag .* is it complete", read_boards, target, BOARD)

    @pytest.mark.parametrize("name", sorted(TYPES))
    def test_a_lacking_topic(self, tmp_path, sensor, name):
        record(tmp_path / "bag", sensor, 1, skip=(name,))
        refused(
            BagError,
            f"no messages on .../{name}; it has /camera/camera/",
            read_boards,
            tmp_path / "bag",
            BOARD,
        )

    def test_aligned_depth_by_topic(self, tmp_path, sensor):
        rename = {"depth/image_rect_raw": f"{PREFIX}/aligned_depth_to_color/image_raw"}
        record(tmp_path / "bag", sensor, 1, rename=rename)
        refused(
            BagError,
            "holds aligned depth, but the map belongs to raw depth",
            read_boards,
            tmp_path / "bag",
            BOARD,
        )

    def test_aligned_depth_by_frame(self, tmp_path, sensor):
        record(tmp_path / "bag", sensor, 1, depth_frame="camera_color_optical_frame")
        refused(BagError, "the depth is aligned to colour", read_boards, tmp_path / "bag", BOARD)

    def test_another_board(self, tmp_path, sensor):
        record(tmp_path / "bag", sensor, 2)
        refused(
            BagError, r"shows no 9x6 board in 2 still poses.*--board",
            read_boards, tmp_path / "bag", Chessboard(9, 6),
        )  # fmt: skip

    def test_too_few_poses_write_nothing(self, tmp_path, sensor):
        record(tmp_path / "bag", sensor, 4)
        refused(
            CalibrationRefusedError, "4 usable views", calibrate_bag, tmp_path / "bag", tmp_path / "unit.npz"
        )
        assert not list(tmp_path.glob("unit*"))

    def test_places_to_write_are_checked_first(self, bag, tmp_path):
        refused(CalibrationFileError, "does not exist", calibrate_bag, bag, tmp_path / "no" / "unit.npz")
        refused(SettingsError, "must end in .npz", calibrate_bag, bag, tmp_path / "unit.yaml")
        refused(SettingsError, "unknown depth model", calibrate_bag, bag, tmp_path / "unit.npz", "magic")


def test_serial_and_temperature_as_the_driver_tells_them():
    def status(name, hardware, *values):
        entries = [SimpleNamespace(key=key, value=value) for key, value in values]
        return SimpleNamespace(name=name, hardware_id=hardware, values=entries)

    other = SimpleNamespace(status=[status("depth_corrector", "depth_corrector")])
    assert camera_health(other, CameraHealth("A", 20.0)) == CameraHealth("A", 20.0)
    warm = SimpleNamespace(status=[status("camera: Temperatures", "1234", ("Asic Temperature", "41.5"))])
    assert camera_health(warm) == CameraHealth("1234", 41.5)
    odd = SimpleNamespace(status=[status("camera: Temperatures", "", ("Asic Temperature", "hot"))])
    assert camera_health(odd, CameraHealth("A", 20.0)) == CameraHealth("A", 20.0)
