"""Nobody gets a picture into a bag without consent: by another type, as text, as numbers or in pieces."""

import base64
import subprocess
import sys

import numpy as np
import pytest
from bathbot_bringup.bag.reading import open_bag, read_messages
from bathbot_bringup.graph.processes import isolated_environment
from bathbot_bringup.graph.running import started
from bathbot_depthcorr.node.stage_node import LATCHED
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

pytestmark = pytest.mark.graph
PICTURE = np.random.default_rng(3).integers(100, 180, 4800, dtype=np.uint8).tobytes()  # a person, in the end
PIECE = 24  # bytes of it that nobody has by chance
HOSTILE = """
import base64, sys, time
import numpy as np
import rclpy
from bathbot_depthcorr.node.dds.participant_node import joining
from bathbot_msgs.msg import ArmState, ScrubSegment
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Pose, TransformStamped
from nav_msgs.msg import Path
from rcl_interfaces.msg import Log
from sensor_msgs.msg import CompressedImage, Image, JointState, PointCloud2
from std_msgs.msg import String, UInt8MultiArray
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker
picture = np.random.default_rng(3).integers(100, 180, 4800, dtype=np.uint8).tobytes()
text, latin = base64.b64encode(picture).decode(), picture.decode("latin-1")
numbers = np.frombuffer(picture, dtype=float)
poses = [Pose(position=Point(x=x, y=y, z=z)) for x, y, z in numbers.reshape(-1, 3).tolist()]
frames = [TransformStamped(child_frame_id=text[at:at + 100]) for at in range(0, len(text), 100)]
sent = [
    ("/tf", Image(data=picture)), ("/left/wrench", CompressedImage(data=picture)),
    ("/left/arm_state", UInt8MultiArray(data=picture)), ("/left/planned_path", PointCloud2(data=picture)),
    ("/robot/camera_info", Marker(text=text)), ("/clock", String(data=text)),
    ("/left/joint_states", JointState(name=[text])), ("/left/joint_states", JointState(name=[latin[:100]])),
    ("/left/joint_states", JointState(position=numbers[:12].tolist())),
    ("/left/joint_states", JointState(effort=numbers.tolist())),
    ("/rosout", Log(msg=text)), ("/rosout", Log(msg=latin)), ("/rosout", Log(msg=text[:900])),
    ("/diagnostics", DiagnosticArray(status=[DiagnosticStatus(values=[KeyValue(value=text[:300])])])),
    ("/right/arm_state", ArmState(reason=text[:400])), ("/right/planned_path", Path()),
    ("/left/scrub_segments", ScrubSegment(poses=poses)), ("/tf_static", TFMessage(transforms=frames)),
]
rclpy.init()
nodes, voices = [], {}
for topic, message in sent:  # a participant may offer one type of a topic only
    if (topic, type(message)) not in voices:
        context = rclpy.Context()
        context.init(domain_id=int(sys.argv[1]))
        with joining(context):
            nodes.append(rclpy.create_node(f"hostile{len(nodes)}", context=context))
        voices[topic, type(message)] = nodes[-1].create_publisher(type(message), topic, 10)
print("ready", flush=True)
while True:
    for topic, message in sent:
        voices[topic, type(message)].publish(message)
    time.sleep(0.05)
"""


def test_no_piece_of_a_picture_is_in_the_bag_and_the_right_types_are(tmp_path):
    with started({}, tmp_path / "logs", "talker") as graph:
        command = [sys.executable, "-c", HOSTILE, str(graph.domain)]
        environment = isolated_environment(graph.domain, tmp_path / "logs")
        hostile = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
        try:
            assert hostile.stdout.readline() == "ready\n"
            node = graph.client.node
            frames = node.create_publisher(TFMessage, "/tf", LATCHED)
            states = node.create_publisher(JointState, "/joint_states", 10)
            graph.start("recorder", {"bag": tmp_path / "bag"})
            graph.wait_until_active()
            assert graph.client.spin_until(
                lambda: frames.get_subscription_count() and states.get_subscription_count(), 10.0
            )
            for _ in range(60):
                frames.publish(TFMessage(transforms=[TransformStamped(child_frame_id="Link1")]))
                states.publish(JointState(name=["joint1"], position=[0.5]))
                graph.client.wait(0.05)
        finally:
            hostile.kill()
            hostile.wait()
    with open_bag(tmp_path / "bag") as reader:
        held = b"".join(bytes(data) for _, _, data in reader.messages())
        topics = {connection.topic for connection in reader.connections if connection.msgcount}
    for hidden in (PICTURE, base64.b64encode(PICTURE)):
        assert not [at for at in range(0, len(hidden) - PIECE, PIECE) if hidden[at : at + PIECE] in held]
    assert {"/tf", "/joint_states"} <= topics
    assert len(list(read_messages(tmp_path / "bag", ("tf",)))) > 40
