"""The node over real DDS: pictures in, targets, surface and the camera's place out."""

import os
import threading
import time

import numpy as np
import pytest
import rclpy
from bathbot_depthcorr.geometry.rigid import inverse, transform_from
from bathbot_depthcorr.node import stage_node  # noqa: F401 - keeps DDS on this machine, before the first context
from bathbot_depthcorr.node.stage_node import LATCHED
from bathbot_depthcorr.ros.messages import (
    extrinsics_from_transform,
    image_from_depth,
    info_from_pinhole,
    stamp_from_seconds,
)
from bathbot_localize.hand_eye.calibration_file import HandEye, save_hand_eye
from bathbot_localize.messages import (
    detections_from_regions,
    stamped_from_transform,
    surface_from_cloud,
    targets_from_contact,
    transforms_from_tf,
)
from bathbot_localize.regions import SkinRegion
from bathbot_localize.target.target import localization_error
from bathbot_localize.target_localizer_node import TargetLocalizer
from diagnostic_msgs.msg import DiagnosticArray
from localize_scene import (
    COLOUR,
    DEPTH,
    T_BASE_COLOUR,
    T_COLOUR_DEPTH,
    box_around,
    hit,
    pixel_of,
    plane,
    render,
    sphere,
    with_noise,
)  # fmt: skip
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import Detection2DArray

from bathbot_msgs.msg import ContactTargets
from bathbot_msgs.srv import SelectRegion

pytestmark = pytest.mark.graph

BALL = sphere((0.55, 0.0, 0.25), 0.15)
T_LINK_COLOUR = transform_from([[0, 0, 1], [-1, 0, 0], [0, -1, 0]], (0.0, 0.059, 0.0))


@pytest.fixture
def ros():
    """A context of its own and a way to spin nodes in the background."""
    rclpy.init(domain_id=1 + (os.getpid() * 7) % 100)
    executor = SingleThreadedExecutor()
    nodes = []

    def spin():
        while rclpy.ok() and not stopping.is_set():
            executor.spin_once(timeout_sec=0.05)

    stopping = threading.Event()
    thread = threading.Thread(target=spin)

    def start(*more):
        for node in more:
            nodes.append(node)
            executor.add_node(node)
        if not thread.is_alive():
            thread.start()

    yield start
    stopping.set()
    if thread.is_alive():
        thread.join(5.0)
    executor.shutdown()
    for node in nodes:
        node.end() if isinstance(node, TargetLocalizer) else node.destroy_node()
    rclpy.try_shutdown()


def wait_for(condition, timeout=20.0, every=lambda: None):
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, f"not within {timeout} s"
        every()
        time.sleep(0.1)


class World:
    """Publishes the scene as camera, corrector and detector would, and keeps what comes back."""

    def __init__(self, node):
        self.node, self.rng = node, np.random.default_rng(3)
        self.clean = render(BALL, plane((1.3, 0.0, 0.0), (-1.0, 0.0, 0.0)))
        self.box = box_around(pixel_of((0.42, 0.05, 0.30)), 45.0)
        self.regions = [SkinRegion("Trunk_skin", 0.9, self.box)]
        publish = node.create_publisher
        self.depth = publish(Image, "depth/corrected/image", 5)
        self.depth_info = publish(CameraInfo, "depth/corrected/camera_info", 5)
        self.colour_info = publish(CameraInfo, "camera/camera/color/camera_info", 5)
        self.detections = publish(Detection2DArray, "skin_regions", 10)
        self.extrinsics = publish(Extrinsics, "depth/corrected/depth_to_color", LATCHED)
        self.static = publish(TFMessage, "/tf_static", LATCHED)
        self.targets, self.surfaces, self.clouds, self.statics, self.status = [], [], [], [], []
        listen = node.create_subscription
        listen(ContactTargets, "contact_targets", self.targets.append, 10)
        listen(PointCloud2, "surface", self.surfaces.append, 5)
        listen(PointCloud2, "body_cloud", self.clouds.append, 5)
        listen(TFMessage, "/tf_static", self.statics.append, LATCHED)
        listen(
            DiagnosticArray, "/diagnostics", lambda message: self.status.append(message.status[0].message), 10
        )
        self.client = node.create_client(SelectRegion, "select_region")

    def publish_fixed(self):
        self.extrinsics.publish(extrinsics_from_transform(T_COLOUR_DEPTH))
        header = Header(frame_id="camera_link")
        self.static.publish(
            TFMessage(
                transforms=[stamped_from_transform(T_LINK_COLOUR, header, "camera_color_optical_frame")]
            )
        )

    def publish_arm(self):
        """An arm that is folded far behind the camera."""
        header = Header(frame_id="base_link")
        far = transform_from(translation=(-2.0, 0.0, 0.0))
        names = (*(f"Link{index}" for index in range(1, 7)), "scrub_head")
        self.static.publish(
            TFMessage(transforms=[stamped_from_transform(far, header, name) for name in names])
        )

    def publish_pictures(self, depth=None):
        stamp = stamp_from_seconds(self.node.get_clock().now().nanoseconds * 1e-9)
        header = Header(stamp=stamp, frame_id="camera_depth_optical_frame")
        self.depth_info.publish(info_from_pinhole(DEPTH, header))
        self.colour_info.publish(info_from_pinhole(COLOUR, header))
        noisy = with_noise(self.clean, self.rng) if depth is None else depth
        self.depth.publish(image_from_depth(noisy, header))
        self.detections.publish(detections_from_regions(self.regions, header))


def parameters(path, **more):
    values = {"hand_eye": str(path), "disc_radius_px": 12.0, **more}
    return [Parameter(name, value=value) for name, value in values.items()]


@pytest.fixture
def world(ros, tmp_path):
    path = tmp_path / "hand_eye.yaml"
    save_hand_eye(HandEye(T_BASE_COLOUR, date="2025-01-01"), path)
    localizer = TargetLocalizer(parameter_overrides=parameters(path))
    assert localizer.autostart()
    node = rclpy.create_node("world")
    world = World(node)
    ros(localizer, node)
    return world


def test_pictures_become_a_target_a_surface_and_the_place_of_the_camera(world):
    world.publish_fixed()
    wait_for(
        lambda: world.targets and world.targets[-1].targets and world.surfaces, every=world.publish_pictures
    )
    message = world.targets[-1]
    (target,) = targets_from_contact(message)
    assert message.header.frame_id == "base_link"
    assert target.region == "Trunk_skin"
    assert localization_error(hit(BALL, target.pixel), target.T_base_target[:3, 3]) < 0.0015
    outward = target.T_base_target[:3, 3] - (0.55, 0.0, 0.25)
    assert -target.T_base_target[:3, 2] @ outward / np.linalg.norm(outward) > np.cos(np.radians(3.0))

    cloud = world.surfaces[-1]
    points = surface_from_cloud(cloud)
    assert cloud.header.frame_id == "base_link"
    assert cloud.height > 10
    distance = np.linalg.norm(points - (0.55, 0.0, 0.25), axis=-1)
    assert np.nanmedian(np.abs(distance - 0.15)) < 0.002

    camera = [
        entry
        for message in world.statics
        for entry in transforms_from_tf(message)
        if entry.child == "camera_link"
    ]
    assert camera[0].parent == "base_link"
    np.testing.assert_allclose(camera[0].transform, T_BASE_COLOUR @ inverse(T_LINK_COLOUR), atol=1e-9)


def test_the_body_is_told_of_only_where_the_arm_can_be_left_out(world):
    world.publish_fixed()
    wait_for(lambda: world.surfaces, every=world.publish_pictures)
    assert not world.clouds
    world.publish_arm()
    wait_for(lambda: world.clouds, every=world.publish_pictures)
    cloud = world.clouds[-1]
    assert (cloud.header.frame_id, cloud.height) == ("base_link", 1)
    points = surface_from_cloud(cloud)[0]
    assert len(points) > 30
    assert np.abs(np.linalg.norm(points - (0.55, 0.0, 0.25), axis=-1) - 0.15).max() < 0.02

    # the lens is covered: the points stay, and what vouches for them grows old
    count, covered = len(world.clouds), np.full_like(world.clean, np.nan)
    wait_for(lambda: len(world.clouds) > count + 1, every=lambda: world.publish_pictures(covered))
    assert len(surface_from_cloud(world.clouds[-1])[0]) >= len(points) - 2
    assert world.clouds[-1].header.stamp == world.clouds[-2].header.stamp
    wait_for(lambda: any("the body is not seen for" in text for text in world.status))


def test_no_depth_gives_an_empty_list_and_a_reason(world):
    world.publish_fixed()
    empty = np.full_like(world.clean, np.nan)
    wait_for(lambda: world.targets, every=lambda: world.publish_pictures(empty))
    assert world.targets[-1].targets == []
    wait_for(
        lambda: any("no depth on skin" in text for text in world.status),
        every=lambda: world.publish_pictures(empty),
    )
    assert not world.surfaces


def test_what_is_missing_is_named(world):
    wait_for(lambda: any("waiting for" in text and "extrinsics" in text for text in world.status))


def test_an_unknown_region_is_refused_with_the_known_ones(world):
    assert world.client.wait_for_service(timeout_sec=10.0)
    future = world.client.call_async(SelectRegion.Request(region="Tail_skin"))
    wait_for(future.done)
    assert future.result().error_code == SelectRegion.Response.UNKNOWN_REGION
    assert "Trunk_skin" in future.result().error_msg
    good = world.client.call_async(SelectRegion.Request(region="Hand_skin"))
    wait_for(good.done)
    assert good.result().error_code == SelectRegion.Response.NONE


def test_without_a_hand_eye_file_the_node_does_not_start(ros):
    node = TargetLocalizer()
    assert not node.autostart()
    ros(node)
    assert "calibrate hand-eye" in node.diagnostic.status.message
