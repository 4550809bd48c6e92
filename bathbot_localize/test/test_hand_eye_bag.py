"""Hand-eye calibration from a bag that the test writes, of an arm that stops and goes."""

import math

import numpy as np
import pytest
from bathbot_depthcorr.geometry.rigid import inverse, quaternion_from_rotation, transform_from
from bathbot_localize.errors import BathbotError
from bathbot_localize.hand_eye.calibration_file import load_hand_eye
from bathbot_localize.hand_eye.recording import HandEyeBagError, calibrate_bag, read_views, still_poses
from bathbot_localize.hand_eye.solver import HandEyeError
from hand_eye_scene import CAMERA, T_BASE_CAMERA, arm_poses, draw_marker
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation, Slerp

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPES = STORE.types
START = 1_700_000_000.0  # 2023-11-14
T_LINK1 = transform_from(Rotation.from_rotvec([0.0, 0.0, 0.3]).as_matrix(), (0.0, 0.0, 0.2405))


def between(first, second, share):
    turn = Slerp([0.0, 1.0], Rotation.from_matrix([first[:3, :3], second[:3, :3]]))(share).as_matrix()
    return transform_from(turn, (1.0 - share) * first[:3, 3] + share * second[:3, 3])


def header(stamp, frame):
    nanoseconds = round(stamp * 1e9)
    time = TYPES["builtin_interfaces/msg/Time"](sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
    return TYPES["std_msgs/msg/Header"](stamp=time, frame_id=frame)


def rotation_of(transform):
    x, y, z, w = quaternion_from_rotation(transform[:3, :3]).tolist()
    return TYPES["geometry_msgs/msg/Quaternion"](x=x, y=y, z=z, w=w)


def tf_message(stamp, T_base_tool):
    entries = []
    for parent, child, transform in (
        ("base_link", "Link1", T_LINK1),
        ("Link1", "Link6", inverse(T_LINK1) @ T_base_tool),
    ):
        x, y, z = transform[:3, 3].tolist()
        body = TYPES["geometry_msgs/msg/Transform"](
            translation=TYPES["geometry_msgs/msg/Vector3"](x=x, y=y, z=z), rotation=rotation_of(transform)
        )
        entries.append(TYPES["geometry_msgs/msg/TransformStamped"](
            header=header(stamp, parent), child_frame_id=child, transform=body
        ))  # fmt: skip
    return TYPES["tf2_msgs/msg/TFMessage"](transforms=entries)


def pose_message(stamp, T_base_tool):
    x, y, z = T_base_tool[:3, 3].tolist()
    pose = TYPES["geometry_msgs/msg/Pose"](
        position=TYPES["geometry_msgs/msg/Point"](x=x, y=y, z=z), orientation=rotation_of(T_base_tool)
    )
    return TYPES["geometry_msgs/msg/PoseStamped"](header=header(stamp, "base_link"), pose=pose)


def image_message(stamp, grey):
    rgb = np.repeat(grey[:, :, None], 3, axis=2)
    return TYPES["sensor_msgs/msg/Image"](
        header=header(stamp, "camera_color_optical_frame"), height=grey.shape[0], width=grey.shape[1],
        encoding="rgb8", is_bigendian=0, step=3 * grey.shape[1], data=rgb.ravel(),
    )  # fmt: skip


def info_message(stamp):
    region = TYPES["sensor_msgs/msg/RegionOfInterest"](
        x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
    )
    k = CAMERA.matrix
    return TYPES["sensor_msgs/msg/CameraInfo"](
        header=header(stamp, "camera_color_optical_frame"), height=CAMERA.height, width=CAMERA.width,
        distortion_model="plumb_bob", d=np.array(CAMERA.distortion), k=k.ravel(), r=np.eye(3).ravel(),
        p=np.hstack([k, np.zeros((3, 1))]).ravel(), binning_x=0, binning_y=0, roi=region,
    )  # fmt: skip


def write_bag(path, poses, rest=0.9, move=0.3, tool_pose=False, colour=True, dark=()):
    """An arm that rests `rest` [s] at each pose and moves `move` [s] between them; two pictures per rest."""
    rng = np.random.default_rng(1)
    topics = {
        "/camera/camera/color/image_raw": "sensor_msgs/msg/Image",
        "/camera/camera/color/camera_info": "sensor_msgs/msg/CameraInfo",
        "/tool_pose" if tool_pose else "/tf": "geometry_msgs/msg/PoseStamped"
        if tool_pose
        else "tf2_msgs/msg/TFMessage",
    }
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        ways = {name: writer.add_connection(name, kind, typestore=STORE) for name, kind in topics.items()}

        def put(name, stamp, message):
            raw = STORE.serialize_cdr(message, topics[name])
            writer.write(ways[name], round(stamp * 1e9), raw)

        put("/camera/camera/color/camera_info", START, info_message(START))
        for index, pose in enumerate(poses):
            begin = START + index * (rest + move)
            following = poses[min(index + 1, len(poses) - 1)]
            for step in range(math.floor((rest + move) * 50)):
                t = step / 50.0
                now = pose if t <= rest else between(pose, following, (t - rest) / move)
                name = "/tool_pose" if tool_pose else "/tf"
                put(
                    name, begin + t, pose_message(begin + t, now) if tool_pose else tf_message(begin + t, now)
                )
            for t in (0.4, 0.6) if colour else ():
                grey = (
                    np.full((CAMERA.height, CAMERA.width), 90, np.uint8)
                    if index in dark
                    else draw_marker(pose, rng)
                )
                put("/camera/camera/color/image_raw", begin + t, image_message(begin + t, grey))
    return path


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write_bag(
        tmp_path_factory.mktemp("bag") / "marker", arm_poses(11, np.random.default_rng(11)), dark=(2,)
    )


def test_a_bag_gives_the_camera_and_a_file(bag, tmp_path):
    told = []
    report = calibrate_bag(bag, tmp_path / "hand_eye.yaml", progress=told.append)
    off = np.linalg.norm(report.hand_eye.T_base_camera[:3, 3] - T_BASE_CAMERA[:3, 3])
    assert off < 0.001
    assert report.hand_eye.poses == 10
    assert report.hand_eye.date == "2023-11-14"
    assert len(told) == 11
    assert "no marker in 2 pictures" in told[2]
    loaded = load_hand_eye(tmp_path / "hand_eye.yaml")
    np.testing.assert_allclose(loaded.T_base_camera, report.hand_eye.T_base_camera, atol=1e-9)
    assert all("\n" not in line for line in report.lines())


def test_tool_pose_serves_as_well(tmp_path):
    path = write_bag(tmp_path / "tool", arm_poses(3, np.random.default_rng(12)), tool_pose=True)
    recording = read_views(path)
    assert len(recording.views) == 3
    assert recording.camera == CAMERA


def test_few_poses_write_nothing(tmp_path):
    path = write_bag(tmp_path / "few", arm_poses(3, np.random.default_rng(13)))
    with pytest.raises(HandEyeError, match="3 still arm poses"):
        calibrate_bag(path, tmp_path / "out.yaml")
    assert not (tmp_path / "out.yaml").exists()


def test_a_bag_without_pictures_says_so(tmp_path):
    path = write_bag(tmp_path / "blind", arm_poses(2, np.random.default_rng(14)), colour=False)
    with pytest.raises(HandEyeBagError, match="image_raw"):
        read_views(path)


def test_a_missing_bag_is_one_line(tmp_path):
    with pytest.raises(BathbotError) as refused:
        calibrate_bag(tmp_path / "nothing", tmp_path / "out.yaml")
    assert "\n" not in str(refused.value)


def test_an_arm_that_never_rests_has_no_still_pose():
    stamps = np.arange(200) / 50.0
    track = np.stack([transform_from(translation=(0.05 * t, 0.0, 0.0)) for t in stamps])
    assert still_poses(stamps, track) == []


def test_rests_are_found_and_shortened():
    stamps = np.arange(200) / 50.0
    place = np.clip(stamps - 1.0, 0.0, 1.0) * 0.1  # rests 0..1 s, moves 1..2 s, rests 2..4 s
    track = np.stack([transform_from(translation=(x, 0.0, 0.0)) for x in place])
    first, second = still_poses(stamps, track)
    assert first.begin == pytest.approx(0.15)
    assert first.end == pytest.approx(0.85, abs=0.03)
    assert second.begin == pytest.approx(2.15, abs=0.03)
    assert second.T_base_tool[0, 3] == pytest.approx(0.1)
