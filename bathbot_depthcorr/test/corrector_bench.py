"""A camera and a listener around the real node, for tests over DDS."""

import threading
import time

import numpy as np
import pytest
import rclpy
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_depthcorr.live.depth_corrector_node import DepthCorrector
from bathbot_depthcorr.models.disparity_spline import DisparitySpline
from bathbot_depthcorr.node import stage_node
from bathbot_depthcorr.ros.messages import image_mm_from_depth, info_from_pinhole, stamp_from_seconds
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

CAMERA = Pinhole(320, 180, 160.0, 160.0, 160.0, 90.0)
TRANSFORM = transform_from(translation=(-0.059, 0.001, 0.0))
FRAME = "camera_depth_optical_frame"


class Bench:
    """A camera and a listener around a node under test, all in one process over DDS."""

    def __init__(self, **settings):
        overrides = [Parameter(name, value=value) for name, value in settings.items()]
        original = rclpy.lifecycle.LifecycleNode.__init__

        def with_overrides(this, name, **keywords):
            original(this, name, parameter_overrides=overrides, **keywords)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(rclpy.lifecycle.LifecycleNode, "__init__", with_overrides)
            self.node = DepthCorrector()
        self.started = self.node.autostart()
        self.camera = rclpy.create_node("bench_camera")
        prefix = "camera/camera"
        self.depth = self.camera.create_publisher(Image, f"{prefix}/depth/image_rect_raw", 5)
        self.info = self.camera.create_publisher(CameraInfo, f"{prefix}/depth/camera_info", 5)
        self.factory = self.camera.create_publisher(
            Extrinsics, f"{prefix}/extrinsics/depth_to_color", stage_node.LATCHED
        )
        self.health = self.camera.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.images, self.infos, self.transforms, self.statuses = [], [], [], []
        for kind, topic, qos, store in (
            (Image, "depth/corrected/image", 5, self.images),
            (CameraInfo, "depth/corrected/camera_info", 5, self.infos),
            (Extrinsics, "depth/corrected/depth_to_color", stage_node.LATCHED, self.transforms),
            (DiagnosticArray, "/diagnostics", 10, self.statuses),
        ):
            self.camera.create_subscription(kind, topic, store.append, qos)
        self.executor = SingleThreadedExecutor()
        self.executor.add_node(self.node)
        self.executor.add_node(self.camera)
        self.open = True
        self.thread = threading.Thread(target=self._spin, daemon=True)
        self.thread.start()

    def _spin(self):
        while self.open:
            self.executor.spin_once(timeout_sec=0.05)

    def header(self, number=0):
        return Header(stamp=stamp_from_seconds(100.0 + number), frame_id=FRAME)

    def until(self, condition, depth=None, camera=CAMERA, seconds=10.0):
        """Play the camera at 20 Hz until a condition holds."""
        end = time.monotonic() + seconds
        number = 0
        while time.monotonic() < end:
            if condition():
                return True
            self.info.publish(info_from_pinhole(camera, self.header(number)))
            if depth is not None:
                self.depth.publish(image_mm_from_depth(depth, self.header(number)))
            number += 1
            time.sleep(0.05)
        return condition()

    def messages(self):
        return [
            (status.level, status.message)
            for array in list(self.statuses) for status in array.status if status.name == "depth_corrector"
        ]  # fmt: skip

    def says(self, level, words):
        return any(found == level and words in message for found, message in self.messages())

    def values(self):
        """What the node's last diagnostic says, key by key."""
        told = [
            status.values for array in list(self.statuses) for status in array.status
            if status.name == "depth_corrector"
        ]  # fmt: skip
        return {entry.key: entry.value for entry in told[-1]} if told else {}

    def close(self):
        self.open = False
        self.thread.join(5.0)
        self.executor.shutdown()
        self.node.end()
        self.camera.destroy_node()


def made_correction():
    """A correction with every part in use."""
    unit = CameraUnit(CAMERA, TRANSFORM, "UNIT-7", 30.0)
    return DisparitySpline(
        unit, np.full((4, 5), 0.01), np.full((4, 5), 0.2), np.zeros(4), 0.07, np.zeros((3, 6, 10))
    )


def flat(depth=0.75):
    image = np.full((CAMERA.height, CAMERA.width), depth, np.float32)
    image[:, :20] = np.nan
    return image
