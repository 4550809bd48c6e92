"""Bags of a simulated D455 before a drawn chessboard, for the tests; no ROS is needed to write them."""

from functools import cache

import cv2
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import Plane
from bathbot_depthcorr.geometry.rigid import inverse, quaternion_from_rotation, transform_from
from bathbot_depthcorr.views.chessboard import Chessboard
from depthcorr_wall import blurred
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

HEALTH = "diagnostic_msgs/msg/DiagnosticArray"
TF = "tf2_msgs/msg/TFMessage"
T_LINK_OPTICAL = transform_from(Rotation.from_euler("xyz", (-np.pi / 2, 0.0, -np.pi / 2)).as_matrix())


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


def health(serial):
    value = make("diagnostic_msgs/msg/KeyValue", key="Asic Temperature", value="31.5")
    kind = STORE.types["diagnostic_msgs/msg/DiagnosticStatus"]
    status = kind(level=0, name="camera: Temperatures", message="", hardware_id=serial, values=[value])
    return make(HEALTH, header=header(0.0, ""), status=[status])


def camera_chain(T_colour_depth):
    """The static frames of a D455: parent, child and transform, camera_link at the depth camera."""
    T_link_colour = T_LINK_OPTICAL @ inverse(T_colour_depth) @ inverse(T_LINK_OPTICAL)
    return [
        ("camera_link", "camera_depth_frame", np.eye(4)),
        ("camera_depth_frame", "camera_depth_optical_frame", T_LINK_OPTICAL),
        ("camera_link", "camera_color_frame", T_link_colour),
        ("camera_color_frame", "camera_color_optical_frame", T_LINK_OPTICAL),
    ]


def static(chain):
    entries = []
    for parent, child, transform in chain:
        x, y, z = transform[:3, 3].tolist()
        turn = dict(zip("xyzw", quaternion_from_rotation(transform[:3, :3]).tolist(), strict=True))
        entries.append(make(
            "geometry_msgs/msg/TransformStamped", header=header(0.0, parent), child_frame_id=child,
            transform=make(
                "geometry_msgs/msg/Transform", translation=make("geometry_msgs/msg/Vector3", x=x, y=y, z=z),
                rotation=make("geometry_msgs/msg/Quaternion", **turn),
            ),
        ))  # fmt: skip
    return make(TF, transforms=entries)


@cache
def drawn(pose):
    """The board on a grey wall, seen by the colour camera, with many samples per pixel; `pose` as bytes."""
    pose = np.frombuffer(pose).reshape(4, 4)
    big = COLOUR.scaled(COLOUR.width * 4, COLOUR.height * 4)
    cells = np.add.outer(np.arange(BOARD.rows + 1), np.arange(BOARD.columns + 1)) % 2
    print_ = np.kron(
        np.pad(cells * 200 + 20, 1, constant_values=230).astype(np.uint8), np.ones((20, 20), np.uint8)
    )
    pitch = BOARD.square / 20
    shift = 0.5 * pitch - 2 * BOARD.square
    metres = np.array([[pitch, 0, shift], [0, pitch, shift], [0, 0, 1]])
    warp = big.matrix @ pose[:3, [0, 1, 3]] @ metres
    large = cv2.warpPerspective(print_, warp, (big.width, big.height), borderValue=120)
    grey = cv2.resize(large, (COLOUR.width, COLOUR.height), interpolation=cv2.INTER_AREA)
    return np.repeat(grey[..., None], 3, axis=2)


def poses(count):
    rng = np.random.default_rng(0)
    for distance in 1.0 / np.linspace(1.0 / 0.6, 1.0 / 1.1, count):
        turn = Rotation.from_euler("xyz", (*rng.uniform(-0.4, 0.4, 2), rng.uniform(-0.1, 0.1))).as_matrix()
        middle = np.array([*rng.uniform(-0.06, 0.06, 2) * distance, distance])
        yield transform_from(turn, middle - turn @ BOARD.corners.mean(axis=0))


def record(
    path, sensor, count, *, frames=4, skip=(), rename=None, depth_frame="camera_depth_optical_frame",
    transform=None, serials=(), chains=(), paint=lambda colour, pose, number: colour,
    hide=lambda mm, pose: mm,
):  # fmt: skip
    """Write a bag of still poses with moving frames between them.

    Each of `chains` is a message of /tf_static. `paint` changes colour by number of pose and picture, `hide`
    depth [mm] by number of the pose.
    """
    rng = np.random.default_rng(1)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {
            name: writer.add_connection((rename or {}).get(name, f"{PREFIX}/{name}"), kind, typestore=STORE)
            for name, kind in TYPES.items() if name not in skip
        }  # fmt: skip
        connections["health"] = writer.add_connection("/diagnostics", HEALTH, typestore=STORE)

        def write(name, stamp, message):
            if name in connections:
                kind = TYPES.get(name, HEALTH)
                writer.write(connections[name], round(stamp * 1e9), STORE.serialize_cdr(message, kind))

        turned = sensor.factory.T_colour_depth if transform is None else transform
        write("color/camera_info", 0.0, info(COLOUR, "camera_color_optical_frame"))
        write("depth/camera_info", 0.0, info(sensor.camera, depth_frame))
        write("extrinsics/depth_to_color", 0.0, make(
            "realsense2_camera_msgs/msg/Extrinsics", rotation=turned[:3, :3].T.ravel(),
            translation=turned[:3, 3].copy(),
        ))  # fmt: skip
        if chains:
            connection = writer.add_connection("/tf_static", TF, typestore=STORE)
            for chain in chains:
                writer.write(connection, 0, STORE.serialize_cdr(static(chain), TF))
        for serial in serials:
            write("health", 0.0, health(serial))
        stamp = 1.0
        noise = np.repeat(0.6 * rng.standard_normal((COLOUR.height, COLOUR.width, 1), np.float32), 3, axis=2)
        for index, pose in enumerate(poses(count)):
            normal = -pose[:3, 2]
            truth = sensor.truth(Plane(normal, float(normal @ pose[:3, 3])))
            frozen, colour = blurred(rng, truth.shape, 3.0, sensor.frozen), drawn(pose.tobytes())
            for number in range(frames + 2):
                stamp += 0.1
                moving = number < 2
                shown = np.roll(colour, 25 * (2 - number), axis=1) if moving else colour
                noisy = cv2.add(shown, np.roll(noise, 37 * number + index, axis=1), dtype=cv2.CV_8U)
                picture = paint(noisy, index, number)
                write("color/image_raw", stamp, image(picture, "rgb8", stamp, "camera_color_optical_frame"))
                depth = sensor.frame(1.3 * truth if moving else truth, rng, frozen)
                mm = hide(np.nan_to_num(depth * 1000.0).round().astype(np.uint16), index)
                write("depth/image_rect_raw", stamp, image(mm, "16UC1", stamp, depth_frame))
