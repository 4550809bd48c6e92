"""A calibration from a recorded bag, made and read without ROS."""

import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from bathbot_depthcorr.calibration.calibrate import calibrate_bag, read_views
from bathbot_depthcorr.calibration.guards import CalibrationRefusedError
from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.errors import BathbotError, SettingsError
from bathbot_depthcorr.files import CalibrationFileError
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_depthcorr.ros.bag_messages import is_bag
from bathbot_depthcorr.ros.camera_health import CameraHealth, camera_health
from bathbot_depthcorr.views.bag_views import BagError, read_boards
from bathbot_depthcorr.views.chessboard import Chessboard
from bathbot_depthcorr.views.view_folder import write_view
from bathbot_depthcorr.views.views import CalibrationView, Steps
from depthcorr_bag import BOARD, PREFIX, TYPES, camera_chain, record
from depthcorr_wall import Sensor, wall
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation


@pytest.fixture(scope="module")
def sensor():
    return Sensor(seed=2, width=424, height=240, least_depth=0.2)


@pytest.fixture(scope="module")
def bag(tmp_path_factory, sensor):
    path = tmp_path_factory.mktemp("bags") / "wall"
    record(path, sensor, 11)
    return path


def test_a_bag_becomes_a_calibration_with_picture_and_report(bag, sensor, tmp_path):
    told = []
    report = calibrate_bag(bag, tmp_path / "unit.npz", progress=told.append)
    assert report.views == 11
    assert report.after < 0.2 * report.before
    correction = load(tmp_path / "unit.npz")
    assert (correction.depth_camera.width, correction.depth_camera.fx) == (424, sensor.camera.fx)
    assert (tmp_path / "unit.png").stat().st_size > 10_000
    assert sum("board found" in line for line in told) == 11


def test_moving_frames_are_left_out(bag):
    recording = read_boards(bag, BOARD)
    assert len(recording.boards) == 11
    assert {board.frames for board in recording.boards} == {4}
    assert all(board.temporal_noise > 0.0 for board in recording.boards)
    centre = [float(np.nanmedian(board.depth[100:140, 190:230])) for board in recording.boards]
    assert max(centre) < 1.25  # while moving, the bag shows 1.3 times the distance


class TestExtrinsics:
    """The depth -> colour transform stands on its own topic, in /tf_static, or in both."""

    EXTRINSICS = "extrinsics/depth_to_color"

    def test_static_frames_serve_as_well(self, sensor, tmp_path):
        """The chain may come in parts: several publishers are latched on /tf_static."""
        chain = camera_chain(sensor.T_colour_depth)
        record(tmp_path / "bag", sensor, 2, skip=(self.EXTRINSICS,), chains=(chain[:1], chain[1:]))
        recording = read_boards(tmp_path / "bag", BOARD)
        assert_allclose(recording.unit.T_colour_depth, sensor.T_colour_depth, atol=1e-9)
        assert recording.notes == []

    def test_both_that_agree_are_not_spoken_of(self, sensor, tmp_path):
        near = transform_from(translation=(0.0, 0.00009, 0.0)) @ sensor.factory.T_colour_depth
        record(tmp_path / "bag", sensor, 2, chains=(camera_chain(near),))
        recording = read_boards(tmp_path / "bag", BOARD)
        assert_allclose(recording.unit.T_colour_depth, sensor.factory.T_colour_depth, atol=1e-9)
        assert recording.notes == []

    @pytest.mark.parametrize(("turn_deg", "shift", "words"), [
        pytest.param(0.0, 0.0002, "0.20 mm and 0.000 deg", id="0.2 mm"),
        pytest.param(0.02, 0.0, "0.020 deg", id="0.02 deg"),
    ])  # fmt: skip
    def test_both_that_differ_are_told_and_the_topic_is_used(self, sensor, tmp_path, turn_deg, shift, words):
        turn = Rotation.from_rotvec((0.0, np.deg2rad(turn_deg), 0.0)).as_matrix()
        other = sensor.factory.T_colour_depth @ transform_from(turn, (0.0, shift, 0.0))
        record(tmp_path / "bag", sensor, 2, chains=(camera_chain(other),))
        recording = read_boards(tmp_path / "bag", BOARD)
        assert_allclose(recording.unit.T_colour_depth, sensor.factory.T_colour_depth, atol=1e-9)
        (note,) = recording.notes
        assert words in note
        assert "extrinsics/depth_to_color is used" in note

    def test_static_frames_of_something_else_do_not_serve(self, sensor, tmp_path):
        other = [("base_link", "Link1", np.eye(4))]
        record(tmp_path / "alone", sensor, 1, skip=(self.EXTRINSICS,), chains=(other,))
        refused(
            BagError, "no messages on .../extrinsics/depth_to_color, and its /tf_static does not join "
            "camera_depth_optical_frame to camera_color_optical_frame",
            read_boards, tmp_path / "alone", BOARD,
        )  # fmt: skip
        record(tmp_path / "both", sensor, 2, chains=(other,))
        assert read_boards(tmp_path / "both", BOARD).notes == []


def test_a_bag_stays_one_whatever_lies_beside_it(bag, sensor, tmp_path):
    """Views may have been written into its folder, or arrays of another program."""
    copy = shutil.copytree(bag, tmp_path / "bag")
    write_view(copy / "view_000.npz", CalibrationView(np.ones((240, 424), np.float32), wall(0.8)))
    assert is_bag(copy)
    assert len(read_views(copy, BOARD, Steps()).views) == 11


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
