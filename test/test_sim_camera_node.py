"""The simulated camera over DDS: pairs of pictures, what stays, and the temperature."""

import pytest
import rclpy
from bathbot_bringup.sim.camera.sim_camera_node import SimCamera
from bathbot_depthcorr.node.stage_node import LATCHED
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.parameter import Parameter
from realsense2_camera_msgs.msg import Extrinsics
from sensor_msgs.msg import CameraInfo, Image, JointState
from tf2_msgs.msg import TFMessage

pytestmark = pytest.mark.graph

SMALL = {"width": 424, "height": 240, "rate": 20.0, "celsius": 31.5}


def test_a_simulated_camera_says_what_a_real_one_says(graph):
    camera = SimCamera(parameter_overrides=[Parameter(name, value=value) for name, value in SMALL.items()])
    client = rclpy.create_node("client")
    heard = {"colour": [], "depth": [], "info": [], "extrinsics": [], "static": [], "states": []}
    listen = client.create_subscription
    prefix = "camera/camera"
    listen(Image, f"{prefix}/color/image_raw", heard["colour"].append, 10)
    listen(Image, f"{prefix}/depth/image_rect_raw", heard["depth"].append, 10)
    listen(CameraInfo, f"{prefix}/depth/camera_info", heard["info"].append, 10)
    listen(Extrinsics, f"{prefix}/extrinsics/depth_to_color", heard["extrinsics"].append, LATCHED)
    listen(TFMessage, "/tf_static", heard["static"].append, LATCHED)
    listen(DiagnosticArray, "/diagnostics", lambda message: heard["states"].extend(message.status), 10)
    joints = client.create_publisher(JointState, "joint_states", 10)
    graph.start(camera, client)
    assert camera.autostart()
    joints.publish(JointState(name=["elbow"], position=[1.0]))  # of another arm: not drawn, no error
    graph.wait_for(lambda: all(heard.values()) and len(heard["depth"]) > 2, 20.0)

    stamps = {(image.header.stamp.sec, image.header.stamp.nanosec) for image in heard["colour"]}
    assert stamps & {(image.header.stamp.sec, image.header.stamp.nanosec) for image in heard["depth"]}
    assert (heard["colour"][0].encoding, heard["depth"][0].encoding) == ("rgb8", "16UC1")
    assert heard["depth"][0].header.frame_id == "camera_depth_optical_frame"
    assert heard["info"][0].width == 424
    frames = [entry.child_frame_id for entry in heard["static"][0].transforms]
    assert "camera_color_optical_frame" in frames
    graph.wait_for(lambda: any("Temperatures" in state.name for state in heard["states"]), 20.0)
    told = next(state for state in heard["states"] if "Temperatures" in state.name)
    assert told.hardware_id == "SIM455-0001-paper"
    assert told.values[0].value == "31.5"

    camera.trigger_deactivate()
    count = len(heard["depth"])
    graph.wait_for(lambda: client.count_subscribers("joint_states") == 0)
    assert len(heard["depth"]) - count <= 1
