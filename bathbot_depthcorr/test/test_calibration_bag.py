"""A calibration from a recorded bag, made and read without ROS."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from bathbot_depthcorr.bag_views import BagError, read_boards
from bathbot_depthcorr.calibrate import calibrate_bag
from bathbot_depthcorr.camera_health import CameraHealth, camera_health
from bathbot_depthcorr.chessboard import Chessboard
from bathbot_depthcorr.correction import load
from bathbot_depthcorr.correction_model import CalibrationFileError
from bathbot_depthcorr.errors import BathbotError, SettingsError
from bathbot_depthcorr.guards import CalibrationRefusedError
from bathbot_depthcorr.pinhole import Pinhole
from bathbot_depthcorr.plane import Plane
from bathbot_depthcorr.rigid import transform_from
from depthcorr_wall import Sensor, blurred
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation

BOARD = Chessboard()
COLOUR = Pinhole(640, 360, 316.0, 316.0, 320.0, 181.0)
STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register(
    get_types_from_msg("float64[9] rotation\nfloat64[3] translation", "realsense2_camera_msgs/msg/Extrinsics")
)
PREFIX = "/camera/camera"
TYPES = {
    "color/image_raw": "sensor_msgs/msg/Image", "color/camera_info": "sensor_msgs/msg/CameraInfo",
    "depth/image_rect_raw": "sensor_msgs/msg/Image", "depth/camera_info": "sensor_msgs/msg/CameraInfo",
    "extrinsics/depth_to_color": "realsense2_camera_msgs/msg/Extrinsics",
}  # fmt: skip


def make(name, **fields):
    return STORE.types[name](**fields)


def header(stamp, frame):
    seconds = int(stamp)
    time = make("builtin_interfaces/msg/Time", sec=seconds, nanosec=round((stamp - seconds) * 1e9))
    return make("std_msgs/msg/Header", stamp=time, frame_id=frame)


def image(array, encoding, stamp, frame):
    return make(
        "sensor_msgs/msg/Image", header=header(stamp, frame), height=array.shape[0], width=array.shape[1],
        encoding=encoding, is_bigendian=0, step=array[0].nbytes,
        data=np.ascontiguousarray(array).view(np.uint8).ravel(),
    )  # fmt: skip


def info(camera, frame):
    roi = make(
        "sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
    )
    return make(
        "sensor_msgs/msg/CameraInfo", header=header(0.0, frame), height=camera.height, width=camera.width,
        distortion_model="plumb_bob", d=np.zeros(5), k=camera.matrix.ravel(), r=np.eye(3).ravel(),
        p=np.column_stack([camera.matrix, np.zeros(3)]).ravel(), binning_x=0, binning_y=0, roi=roi,
    )  # fmt: skip


def draw(pose):
    """The board on a grey wall, seen by the colour camera, with many samples per pixel."""
    big = COLOUR.scaled(COLOUR.width * 4, COLOUR.height * 4)
    cells = np.add.outer(np.arange(BOARD.rows + 1), np.arange(BOARD.columns + 1)) % 2
    print_ = np.kron(
        np.pad(cells * 200 + 20, 1, constant_values=230).astype(np.uint8), np.ones((20, 20), np.uint8)
    )
    pitch = BOARD.square / 20
    shift = 0.5 * pitch - 2 * BOARD.square
    metres = np.array([[pitch, 0, shift], [0, pitch, shift], [0, 0, 1]])
    warp = big.matrix @ pose[:3, [0, 1, 3]] @ metres
    drawn = cv2.warpPerspective(print_, warp, (big.width, big.height), borderValue=120)
    grey = cv2.resize(drawn, (COLOUR.width, COLOUR.height), interpolation=cv2.INTER_AREA)
    return np.repeat(grey[..., None], 3, axis=2)


def poses(count):
    rng = np.random.default_rng(0)
    for distance in 1.0 / np.linspace(1.0 / 0.6, 1.0 / 1.1, count):
        turn = Rotation.from_euler("xyz", (*rng.uniform(-0.4, 0.4, 2), rng.uniform(-0.1, 0.1))).as_matrix()
        middle = np.array([*rng.uniform(-0.06, 0.06, 2) * distance, distance])
        yield transform_from(turn, middle - turn @ BOARD.corners.mean(axis=0))


def record(path, sensor, count, *, frames=4, skip=(), rename=None, depth_frame="camera_depth_optical_frame"):
    """Write a bag of still poses with moving frames between them."""
    rng = np.random.default_rng(1)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {
            name: writer.add_connection((rename or {}).get(name, f"{PREFIX}/{name}"), kind, typestore=STORE)
            for name, kind in TYPES.items() if name not in skip
        }  # fmt: skip

        def write(name, stamp, message):
            if name in connections:
                writer.write(connections[name], round(stamp * 1e9), STORE.serialize_cdr(message, TYPES[name]))

        turned = sensor.factory.T_colour_depth
        write("color/camera_info", 0.0, info(COLOUR, "camera_color_optical_frame"))
        write("depth/camera_info", 0.0, info(sensor.camera, depth_frame))
        write("extrinsics/depth_to_color", 0.0, make(
            "realsense2_camera_msgs/msg/Extrinsics", rotation=turned[:3, :3].T.ravel(),
            translation=turned[:3, 3].copy(),
        ))  # fmt: skip
        stamp = 1.0
        for pose in poses(count):
            normal = -pose[:3, 2]
            truth = sensor.truth(Plane(normal, float(normal @ pose[:3, 3])))
            frozen, colour = blurred(rng, truth.shape, 3.0, sensor.frozen), draw(pose)
            for number in range(frames + 2):
                stamp += 0.1
                moving = number < 2
                shown = np.roll(colour, 25 * (2 - number), axis=1) if moving else colour
                noisy = np.clip(shown + rng.normal(0.0, 1.0, shown.shape), 0, 255).astype(np.uint8)
                write("color/image_raw", stamp, image(noisy, "rgb8", stamp, "camera_color_optical_frame"))
                depth = sensor.frame(1.3 * truth if moving else truth, rng, frozen)
                mm = np.nan_to_num(depth * 1000.0).round().astype(np.uint16)
                write("depth/image_rect_raw", stamp, image(mm, "16UC1", stamp, depth_frame))


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

    def test_another_board(self, bag):
        refused(
            BagError, r"shows no 9x6 board in 14 still poses.*--board", read_boards, bag, Chessboard(9, 6)
        )

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
