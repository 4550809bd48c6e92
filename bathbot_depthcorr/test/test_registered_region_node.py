import numpy as np
import pytest
import rclpy
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.registration import Region, Registration, region_camera
from bathbot_depthcorr.node import stage_node
from bathbot_depthcorr.ros.messages import (
    depth_from_image,
    extrinsics_from_transform,
    info_from_pinhole,
    pinhole_from_info,
)
from corrector_bench import CAMERA, TRANSFORM, Bench, flat, made_correction
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

pytestmark = pytest.mark.graph

DOMAIN = 45
COLOUR = Pinhole(320, 180, 158.0, 158.0, 160.0, 91.0, (-0.05, 0.06, -0.0007, 0.0, -0.02))
REGION = Region(120, 60, 64, 48)
FRAME = "camera_color_optical_frame"


class ColourBench(Bench):
    """A bench that also has a colour camera, and listens to the registered region."""

    def __init__(self, **settings):
        super().__init__(**settings)
        self.colour = self.camera.create_publisher(CameraInfo, "camera/camera/color/camera_info", 5)
        self.patches, self.patch_infos = [], []
        for kind, name, store in (
            (Image, "image", self.patches), (CameraInfo, "camera_info", self.patch_infos),
        ):  # fmt: skip
            self.camera.create_subscription(kind, f"depth/registered/{name}", store.append, 5)

    def until(self, condition, depth=None, colour=COLOUR, **keywords):
        def seen():
            self.colour.publish(info_from_pinhole(colour, Header(frame_id=FRAME)))
            return condition()

        return super().until(seen, depth, **keywords)


@pytest.fixture(scope="module", autouse=True)
def ros():
    rclpy.init(domain_id=DOMAIN)
    yield
    rclpy.try_shutdown()


@pytest.fixture
def bench():
    made = []

    def make(**settings):
        made.append(ColourBench(**settings))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.fixture
def calibration(tmp_path):
    made_correction().save(tmp_path / "unit.npz")
    return str(tmp_path / "unit.npz")


def test_the_region_arrives_in_the_colour_frame(bench, calibration):
    node = bench(calibration=calibration, registered_roi=list(REGION))
    assert node.until(lambda: node.patches and node.patch_infos, flat())
    patch, info = node.patches[-1], node.patch_infos[-1]
    expected = Registration(CAMERA, COLOUR, TRANSFORM, REGION).apply(made_correction().apply(flat()))
    np.testing.assert_allclose(depth_from_image(patch), expected, rtol=1e-5)
    assert (patch.header.frame_id, info.header.frame_id) == (FRAME, FRAME)
    assert pinhole_from_info(info) == region_camera(COLOUR, REGION)
    assert node.until(lambda: patch.header.stamp in [one.header.stamp for one in list(node.images)], flat())


def test_without_calibration_the_factory_transform_is_used(bench):
    node = bench(registered_roi=list(REGION))
    node.factory.publish(extrinsics_from_transform(TRANSFORM))
    assert node.until(lambda: bool(node.patches), flat())
    expected = Registration(CAMERA, COLOUR, TRANSFORM, REGION).apply(flat())
    np.testing.assert_allclose(depth_from_image(node.patches[-1]), expected, rtol=1e-5)


def test_a_region_outside_the_colour_image_is_told_and_depth_goes_on(bench, calibration):
    node = bench(calibration=calibration, registered_roi=[300, 60, 64, 48])
    words = "registered_roi: region 64x48 at (300, 60) leaves the colour image of 320x180"
    assert node.until(lambda: node.says(stage_node.ERROR, words) and node.images, flat())
    assert not node.patches


def test_a_region_of_negative_numbers_fails_to_start_with_one_line(bench, calibration):
    node = bench(calibration=calibration, registered_roi=[0, 0, -5, 48])
    assert not node.started
    assert node.until(lambda: node.says(stage_node.ERROR, "registered_roi must be left, top, width"))


def test_no_region_is_offered_unless_asked_for(bench, calibration):
    node = bench(calibration=calibration)
    assert node.until(lambda: bool(node.images), flat())
    assert not node.node.get_publishers_info_by_topic("/depth/registered/image")
