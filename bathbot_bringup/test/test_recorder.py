"""The recorder as a process of its own, hearing this one over real DDS; and the writer alone."""

import os
import subprocess
import sys
import time

import pytest
from bathbot_bringup.bag.reading import bag_length, open_bag, read_messages, summarise_bag
from bathbot_bringup.bag.recorder import Recorder, Topic
from bathbot_bringup.errors import BagError
from bathbot_bringup.graph.isolation import free_domain, used_ports
from bathbot_bringup.graph.message_types import installed_types
from bathbot_bringup.graph.node_table import find_node, node_command
from bathbot_bringup.graph.processes import isolated_environment
from bathbot_bringup.graph.running import started
from bathbot_depthcorr.node.stage_node import LATCHED
from bathbot_depthcorr.ros.verdict import Level
from geometry_msgs.msg import TransformStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image, PointCloud2
from tf2_msgs.msg import TFMessage

from bathbot_msgs.msg import ArmState

STATE = "bathbot_msgs/msg/ArmState"


def state(count: int) -> ArmState:
    return ArmState(path_id=count, reason=f"number {count}", force=0.5 * count)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A bag of the default profile: states, a latched transform, and pictures that must not be in it."""
    folder = tmp_path_factory.mktemp("recorder")
    with started({}, folder / "logs", "talker") as graph:
        node = graph.client.node
        static = node.create_publisher(TFMessage, "/tf_static", LATCHED)
        static.publish(TFMessage(transforms=[TransformStamped(child_frame_id="camera_link")]))
        states = node.create_publisher(ArmState, "left/arm_state", 10)
        pictures = node.create_publisher(Image, "camera/color/image_raw", 10)
        clouds = node.create_publisher(PointCloud2, "surface", 10)
        graph.start("recorder", {"bag": folder / "bag"})
        graph.wait_until_active()
        assert graph.client.spin_until(lambda: states.get_subscription_count() == 1, 5.0)
        for count in range(200):
            states.publish(state(count))
            pictures.publish(Image(data=b"skin"))
            clouds.publish(PointCloud2())
            graph.client.wait(0.0)
            time.sleep(0.005)
        graph.client.wait(0.3)
    return folder / "bag"


@pytest.mark.graph
def test_all_messages_of_an_own_type_are_there_in_order(recorded):
    found = [entry.message for entry in read_messages(recorded, ("arm_state",))]
    assert [message.path_id for message in found] == list(range(200))
    assert (found[7].reason, found[7].force) == ("number 7", 3.5)


@pytest.mark.graph
def test_what_was_latched_before_is_there(recorded):
    (entry,) = read_messages(recorded, ("tf_static",))
    assert entry.message.transforms[0].child_frame_id == "camera_link"
    with open_bag(recorded) as reader:
        (latched,) = (c for c in reader.connections if c.topic == "/tf_static")
    assert latched.ext.offered_qos_profiles[0].durability.name == "TRANSIENT_LOCAL"


@pytest.mark.graph
def test_no_picture_and_no_cloud_of_a_person_is_there(recorded):
    assert not {"/camera/color/image_raw", "/surface"} & {topic.name for topic in summarise_bag(recorded)}


@pytest.mark.graph
def test_names_are_resolved(recorded):
    assert "/left/arm_state" in {topic.name for topic in summarise_bag(recorded)}


@pytest.mark.graph
def test_other_readers_understand_it(recorded):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with (recorded / "bag.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        ids = [message.path_id for _, _, _, message in reader.iter_decoded_messages(["/left/arm_state"])]
    assert ids == list(range(200))


@pytest.mark.graph
def test_the_profile_is_noted_in_the_bag(recorded):
    assert "privacy_profile: default" in (recorded / "metadata.yaml").read_text()


@pytest.mark.graph
def test_nothing_unfinished_lies_beside_it(recorded):
    assert {file.name for file in recorded.parent.iterdir()} <= {"bag", "logs", "ros"}


@pytest.mark.graph
@pytest.mark.parametrize(("parameters", "said"), [
    pytest.param({}, "bag is empty", id="no bag"),
    pytest.param({"bag": "x", "profile": "all"}, "no privacy profile is named 'all'", id="profile"),
    pytest.param({"bag": "x", "profile": "calibration"}, "needs consent", id="consent"),
    pytest.param({"bag": "x", "search_period": 99.0}, "search_period must lie in", id="value"),
    pytest.param({"bag": "x", "speed": 1}, "unknown parameter speed", id="name"),
])  # fmt: skip
def test_a_bad_parameter_is_one_line_and_exit_code_2(tmp_path, parameters, said):
    command = node_command(find_node("recorder"), parameters)
    environment = isolated_environment(free_domain(os.getpid(), used_ports()), tmp_path)
    outcome = subprocess.run(
        command, env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=30
    )
    assert outcome.returncode == 2
    assert said in outcome.stderr
    assert "Traceback" not in outcome.stderr
    assert not (tmp_path / "x").exists()


def write(target, messages, **options) -> None:
    recorder = Recorder(target, **options)
    recorder.add(Topic("/arm_state", STATE, []))
    for count, stamp in enumerate(messages):
        recorder.put("/arm_state", stamp, serialize_message(state(count)))
    recorder.close()


@settings(max_examples=15, deadline=None)
@given(stamps=st.lists(st.integers(1, 2**62), min_size=1, max_size=30))
def test_what_is_put_comes_back(tmp_path_factory, stamps):
    target = tmp_path_factory.mktemp("bag") / "run"
    write(target, stamps)
    entries = list(read_messages(target, ("arm_state",)))
    assert [entry.time for entry in entries] == sorted(stamps)
    assert sorted(entry.message.path_id for entry in entries) == list(range(len(stamps)))


def test_a_single_file_when_the_name_says_so(tmp_path):
    write(tmp_path / "run.mcap", [1_000_000_000, 3_000_000_000])
    assert (tmp_path / "run.mcap").is_file()
    assert bag_length(tmp_path / "run.mcap") == pytest.approx(2.0)
    assert bag_length(tmp_path) == pytest.approx(2.0), "the folder is a rosbag2 bag too"


def test_an_empty_recording_is_a_bag(tmp_path):
    write(tmp_path / "run", [])
    assert summarise_bag(tmp_path / "run")[0].messages == 0
    assert bag_length(tmp_path / "run") == 0.0


def test_nothing_is_overwritten(tmp_path):
    write(tmp_path / "run", [1])
    with pytest.raises(BagError, match="exists already"):
        Recorder(tmp_path / "run")


def test_a_place_that_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(BagError, match=r"cannot write a bag at .*choose another place"):
        Recorder(tmp_path / "file" / "run")


def test_what_does_not_fit_the_queue_is_dropped_and_counted(tmp_path):
    recorder = Recorder(tmp_path / "run", queue_bytes=10)
    recorder.add(Topic("/arm_state", STATE, []))
    recorder.put("/arm_state", 1, bytes(1000))
    assert recorder.close().dropped == 1


def test_the_definitions_of_all_our_types_are_known():
    assert {STATE, "bathbot_msgs/msg/SimContact", "vision_msgs/msg/Detection2DArray",
            "realsense2_camera_msgs/msg/Extrinsics"} <= set(installed_types().fielddefs)  # fmt: skip


@pytest.mark.graph
def test_an_interrupted_recorder_closes_its_bag(tmp_path):
    """Ctrl-C of the command line: the bag is whole and listed."""
    import signal

    environment = isolated_environment(free_domain(os.getpid() + 1, used_ports()), tmp_path)
    command = [sys.executable, "-m", "bathbot_bringup.command.cli", "record", "--out", str(tmp_path / "bag")]
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        deadline = time.monotonic() + 20.0
        while not list(tmp_path.glob(".bag.*.part")) and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20.0)
    assert (process.returncode, err) == (0, "")
    assert "wrote" in out
    assert summarise_bag(tmp_path / "bag")


def test_a_recorder_tells_how_it_goes(tmp_path):
    recorder = Recorder(tmp_path / "bag", queue_bytes=10)
    recorder.add(Topic("/arm_state", STATE, []))
    assert recorder.verdict("default") == (Level.OK, "recording profile default")
    recorder.put("/arm_state", 1, bytes(11))
    assert recorder.verdict("default") == (Level.WARN, "the disk is too slow, messages were dropped")
    recorder.failure = "no space left"
    assert recorder.verdict("default") == (Level.ERROR, "cannot write the bag: no space left")
    with pytest.raises(BagError, match="is not whole"):
        recorder.close()
