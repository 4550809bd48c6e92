"""The node over real DDS, in this process."""

import os
import threading
import time

import numpy as np
import pytest
import rclpy
from bathbot_depthcorr.node.stage_node import LATCHED
from bathbot_perception.skin_detector_node import SkinDetector
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from sensor_msgs.msg import Image
from tiny_model import row
from vision_msgs.msg import Detection2DArray, LabelInfo

pytestmark = pytest.mark.graph


class Listener:
    """A camera and somebody who wants to know what the detector says."""

    def __init__(self):
        self.node = rclpy.create_node("listener")
        self.detections, self.labels, self.states = [], [], []
        self.camera = self.node.create_publisher(Image, "camera/camera/color/image_raw", 5)
        self.node.create_subscription(Detection2DArray, "skin_regions", self.detections.append, 10)
        self.node.create_subscription(LabelInfo, "skin_regions/label_info", self.labels.append, LATCHED)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._keep_state, 10)

    def _keep_state(self, message):
        self.states.extend(s for s in message.status if s.name == "skin_detector")

    def show(self, seconds=1, encoding="rgb8"):
        picture = np.zeros((64, 128, 3), np.uint8)
        image = Image(height=64, width=128, step=384, encoding=encoding, data=picture.tobytes())
        image.header.stamp.sec, image.header.frame_id = seconds, "camera_color_optical_frame"
        self.camera.publish(image)


def until(condition, timeout=15.0):
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, f"not within {timeout} s"
        time.sleep(0.02)


@pytest.fixture
def graph(write_model, request):
    """A detector with a model that sees a hand, or the one that a test names."""
    rclpy.init(domain_id=102 + os.getpid() % 100)
    model = getattr(request, "param", None) or write_model([row("Hand_skin", 0.9, (32.0, 24.0), (16.0, 8.0))])
    node = SkinDetector(parameter_overrides=[Parameter("model", value=str(model))])
    listener = Listener()
    executor = SingleThreadedExecutor()
    executor.add_node(listener.node)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin)
    thread.start()
    yield listener, node
    executor.shutdown()
    thread.join(5.0)
    node.end()
    listener.node.destroy_node()
    rclpy.try_shutdown()


def test_a_picture_becomes_detections_with_its_header(graph):
    listener, node = graph
    assert node.autostart()
    until(lambda: listener.camera.get_subscription_count() == 1)
    listener.show(seconds=7)
    until(lambda: listener.detections)
    message = listener.detections[0]
    assert (message.header.stamp.sec, message.header.frame_id) == (7, "camera_color_optical_frame")
    assert message.detections[0].header == message.header
    assert message.detections[0].results[0].hypothesis.class_id == "Hand_skin"
    assert message.detections[0].bbox.center.position.x == pytest.approx(64.0)
    until(lambda: listener.labels)
    assert listener.labels[0].class_map[4].class_name == "Hand_skin"


def test_diagnostics_say_what_is_wrong_in_plain_words(graph):
    listener, node = graph
    assert node.autostart()
    until(lambda: any("no picture on /camera/camera/color/image_raw" in s.message for s in listener.states))
    listener.show(encoding="mono8")
    until(lambda: any("encoding 'mono8'" in s.message for s in listener.states))
    listener.show()
    until(lambda: listener.states[-1].message == "detecting")
    values = {item.key: item.value for item in listener.states[-1].values}
    assert values["provider"] == "CPUExecutionProvider"
    assert {"fps", "latency_ms", "detection_ms", "dropped"} <= set(values)


@pytest.mark.parametrize("graph", ["/nowhere/skin.onnx"], indirect=True)
def test_a_bad_model_is_one_clear_line_and_no_start(graph):
    listener, node = graph
    assert not node.autostart()
    until(lambda: any("there is no model file /nowhere/skin.onnx" in s.message for s in listener.states))


def test_a_stopped_detector_is_silent_and_starts_again(graph):
    listener, node = graph
    assert node.autostart()
    node.trigger_deactivate()
    until(lambda: listener.camera.get_subscription_count() == 0)
    node.trigger_activate()
    until(lambda: listener.camera.get_subscription_count() == 1)
    listener.show()
    until(lambda: listener.detections)
