import numpy as np
import pytest
import rclpy
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.node import stage_node
from bathbot_depthcorr.node.stage_node import LATCHED
from bathbot_depthcorr.ros.messages import (
    depth_from_image,
    extrinsics_from_transform,
    image_mm_from_depth,
    pinhole_from_info,
    transform_from_extrinsics,
)
from corrector_bench import CAMERA, FRAME, TRANSFORM, Bench, flat, made_correction
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from realsense2_camera_msgs.msg import Extrinsics

pytestmark = pytest.mark.graph

DOMAIN = 44


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
    correction = made_correction()
    correction.save(tmp_path / "unit.npz")
    return correction, str(tmp_path / "unit.npz")


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


def test_the_fitted_transform_is_sent_once_and_kept_for_late_listeners(bench, calibration):
    node = bench(calibration=calibration[1])
    wrong = TRANSFORM.copy()
    wrong[0, 3] += 0.01
    node.factory.publish(extrinsics_from_transform(wrong))
    assert node.until(lambda: len(node.images) > 10, flat())
    assert len(node.transforms) == 1
    late = []
    node.camera.create_subscription(Extrinsics, "depth/corrected/depth_to_color", late.append, LATCHED)
    assert node.until(lambda: bool(late))
    np.testing.assert_allclose(transform_from_extrinsics(late[0]), TRANSFORM, atol=1e-7)


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


def test_frames_that_share_memory_arrive_each_as_it_was(bench, calibration):
    correction, path = calibration
    node = bench(calibration=path)
    assert node.until(lambda: bool(node.images), flat())
    sent = {node.header(1000 + i).stamp.sec: flat(z) for i, z in enumerate((0.5, 0.8, 1.1, 1.4))}
    for number, frame in enumerate(sent.values()):
        node.depth.publish(image_mm_from_depth(frame, node.header(1000 + number)))
    assert node.until(lambda: set(sent) <= {one.header.stamp.sec for one in list(node.images)})
    for image in node.images:
        if image.header.stamp.sec in sent:
            expected = correction.apply(sent[image.header.stamp.sec])
            np.testing.assert_allclose(depth_from_image(image), expected, rtol=1e-6)


def test_diagnostics_tell_how_good_depth_is(bench, calibration):
    correction, path = calibration
    true = float(correction.apply(flat())[90, 160])
    node = bench(calibration=path, wall_distance=true / 1.01)
    assert node.until(lambda: node.values().get("fill", "unknown") != "unknown", flat())
    told = node.values()
    assert float(told["fill"]) == pytest.approx(15 / 16, abs=0.002)
    assert float(told["plane_rmse_mm"]) < 1.0
    assert float(told["sigma_mm"]) > 0.0
    assert told["z_accuracy"] == "+1.00 %"
    assert told["model"] == "disparity_spline"


def test_a_camera_that_falls_silent_is_noticed(bench, calibration):
    node = bench(calibration=calibration[1])
    assert node.until(lambda: node.says(stage_node.OK, "correcting"), flat())
    node.statuses.clear()
    assert node.until(lambda: node.says(stage_node.WARN, "waiting for depth images"))
