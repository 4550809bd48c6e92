import threading
import time

import numpy as np
import pytest
import rclpy
from bathbot_depthcorr.correction_model import CameraUnit
from bathbot_depthcorr.depth_corrector_node import DepthCorrector
from bathbot_depthcorr.disparity_spline import DisparitySpline
from bathbot_depthcorr.messages import (
    depth_from_image,
    extrinsics_from_transform,
    image_mm_from_depth,
    info_from_pinhole,
    pinhole_from_info,
    stamp_from_seconds,
    transform_from_extrinsics,
)
from bathbot_depthcorr.pinhole import Pinhole
from bathbot_depthcorr.rigid import transform_from
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from bathbot_depthcorr import stage_node

CAMERA = Pinhole(320, 180, 160.0, 160.0, 160.0, 90.0)
TRANSFORM = transform_from(translation=(-0.059, 0.001, 0.0))
DOMAIN = 44
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

    def close(self):
        self.open = False
        self.thread.join(5.0)
        self.executor.shutdown()
        self.node.end()
        self.camera.destroy_node()


@pytest.fixture(scope="module", autouse=True)
def ros():
    rclpy.init(domain_id=DOMAIN)
    yield
    rclpy.try_shutdown()


@pytest.fixture
def bench():
    made = []

    def make(**settings):
        made.append(Bench(**settings))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.fixture
def calibration(tmp_path):
    unit = CameraUnit(CAMERA, TRANSFORM, "UNIT-7", 30.0)
    correction = DisparitySpline(
        unit, np.full((4, 5), 0.01), np.full((4, 5), 0.2), np.zeros(4), 0.07, np.zeros((3, 6, 10))
    )
    correction.save(tmp_path / "unit.npz")
    return correction, str(tmp_path / "unit.npz")


def flat(depth=0.75):
    image = np.full((CAMERA.height, CAMERA.width), depth, np.float32)
    image[:, :20] = np.nan
    return image


def test_corrected_depth_transform_and_info_arrive(bench, calibration):
    correction, path = calibration
    node = bench(calibration=path)
    assert node.started
    assert node.until(lambda: node.images and node.transforms and node.infos, flat())
    image = node.images[-1]
    assert image.encoding == "32FC1"
    assert image.header.frame_id == FRAME
    np.testing.assert_allclose(depth_from_image(image), correction.apply(flat()), rtol=1e-6)
    np.testing.assert_allclose(transform_from_extrinsics(node.transforms[-1]), TRANSFORM, atol=1e-7)
    assert pinhole_from_info(node.infos[-1]) == CAMERA
    assert node.infos[-1].header.stamp in [one.header.stamp for one in node.images]


def test_another_lens_is_refused_and_nothing_is_published(bench, calibration):
    node = bench(calibration=calibration[1])
    other = Pinhole(320, 180, 163.0, 163.0, 160.0, 90.0)
    assert node.until(
        lambda: node.says(stage_node.ERROR, "fx 160.00 px, camera has 163.00 px"), flat(), other
    )
    assert not node.images
    assert not node.transforms


def test_another_serial_number_on_diagnostics_is_refused(bench, calibration):
    node = bench(calibration=calibration[1])
    assert node.until(lambda: bool(node.images), flat())
    entry = KeyValue(key="Asic Temperature", value="31.0")
    status = DiagnosticStatus(name="camera: Temperatures", hardware_id="UNIT-8", values=[entry])
    node.health.publish(DiagnosticArray(status=[status]))
    assert node.until(lambda: node.says(stage_node.ERROR, "UNIT-7, connected is UNIT-8"), flat())


def test_without_calibration_depth_passes_with_a_warning(bench):
    node = bench()
    node.factory.publish(extrinsics_from_transform(TRANSFORM))
    assert node.until(lambda: node.images and node.transforms, flat())
    np.testing.assert_allclose(depth_from_image(node.images[-1]), flat())
    np.testing.assert_allclose(transform_from_extrinsics(node.transforms[-1]), TRANSFORM, atol=1e-7)
    assert node.until(lambda: node.says(stage_node.WARN, "uncorrected"), flat())


def test_a_covered_lens_is_an_error(bench, calibration):
    node = bench(calibration=calibration[1])
    assert node.until(lambda: node.says(stage_node.ERROR, "no depth"), np.full((180, 320), np.nan))
    assert np.isnan(depth_from_image(node.images[-1])).all()


def test_a_missing_file_fails_to_start_with_one_line(bench, tmp_path):
    node = bench(calibration=str(tmp_path / "absent.npz"))
    assert not node.started
    assert node.until(lambda: node.says(stage_node.ERROR, "no depth calibration at"))


def test_a_frame_of_another_size_is_an_error_not_a_crash(bench, calibration):
    node = bench(calibration=calibration[1])
    assert node.until(lambda: node.says(stage_node.ERROR, "shape (90, 160)"), flat()[::2, ::2])
    assert node.until(lambda: bool(node.images), flat())
