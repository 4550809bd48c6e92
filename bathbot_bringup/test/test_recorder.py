"""The recorder as a process of its own, hearing this one over real DDS; and the writer alone."""

import errno
import os
import shutil
import signal
import subprocess
import sys
import threading
import time

import pytest
from bathbot_bringup.bag.message_types import installed_types
from bathbot_bringup.bag.reading import bag_length, notes_of, open_bag, read_messages, summarise_bag
from bathbot_bringup.bag.recording.mcap_bag import Source, Stored, Topic
from bathbot_bringup.bag.recording.privacy import Consent, find_profile
from bathbot_bringup.bag.recording.record import record_graph
from bathbot_bringup.bag.recording.recorder import LOST, REFUSED, Recorder
from bathbot_bringup.errors import BagError
from bathbot_bringup.graph.installation import config_file
from bathbot_bringup.graph.isolation import free_domain, used_ports
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

STATES = Source("/arm_state", "bathbot_msgs/msg/ArmState")
PROFILE = find_profile(config_file("bathbot_bringup", "privacy_profiles.yaml"), "metrics_only")


def state(count: int) -> ArmState:
    return ArmState(path_id=count, reason=f"number {count}", force=0.5 * count)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A bag of the profile metrics_only: states, a latched transform, and pictures that must not be in it."""
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
def test_when_each_was_sent_and_its_senders_count_are_there(recorded):
    from mcap.reader import make_reader

    with (recorded / "bag.mcap").open("rb") as file:
        sent = [message for _, _, message in make_reader(file).iter_messages(["/left/arm_state"])]
    numbers = [message.sequence for message in sent]
    assert numbers == list(range(numbers[0], numbers[0] + 200))
    delays = [message.log_time - message.publish_time for message in sent]
    assert all(0 < delay < 1e9 for delay in delays)
    assert len({message.publish_time for message in sent}) == 200


@pytest.mark.graph
def test_messages_lost_on_their_way_are_counted(tmp_path):
    with started({}, tmp_path / "logs", "talker") as graph:
        states = graph.client.node.create_publisher(ArmState, "arm_state", 500)
        recorder = graph.start("recorder", {"bag": tmp_path / "bag"})
        graph.wait_until_active()
        assert graph.client.spin_until(lambda: states.get_subscription_count() == 1, 5.0)
        states.publish(state(0))
        graph.client.wait(0.5)
        recorder.process.send_signal(signal.SIGSTOP)
        for count in range(1, 400):
            states.publish(state(count))
        time.sleep(0.5)
        recorder.process.send_signal(signal.SIGCONT)
        graph.client.wait(0.5)
        states.publish(state(400))
        graph.client.wait(0.5)
    found = [entry.message.path_id for entry in read_messages(tmp_path / "bag", ("arm_state",))]
    assert (found[0], found[-1]) == (0, 400)
    lost = int(notes_of(tmp_path / "bag")[LOST])
    assert lost == 401 - len(found) > 0


@pytest.mark.graph
def test_the_profile_is_noted_in_the_bag(recorded):
    assert '"privacy_profile": "metrics_only"' in (recorded / "metadata.yaml").read_text()


@pytest.mark.graph
def test_nothing_unfinished_lies_beside_it(recorded):
    assert {file.name for file in recorded.parent.iterdir()} <= {"bag", "logs", "ros"}


@pytest.mark.graph
@pytest.mark.parametrize(("parameters", "said"), [
    pytest.param({}, "bag is empty", id="no bag"),
    pytest.param({"bag": "x", "profile": "all"}, "no privacy profile is named 'all'", id="profile"),
    pytest.param({"bag": "x", "profile": "full"}, "needs consent", id="consent"),
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


def put(recorder, count, stamp=1, message=None):
    recorder.put(Stored(STATES, stamp, serialize_message(message or state(count))))


def write(target, stamps, **options) -> None:
    recorder = Recorder(target, PROFILE, **options)
    recorder.add(Topic(STATES, []))
    for count, stamp in enumerate(stamps):
        put(recorder, count, stamp)
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


def test_of_a_topic_that_is_not_there_nothing_is_read(tmp_path):
    write(tmp_path / "run", [1, 2])
    assert list(read_messages(tmp_path / "run", ("joint_states",))) == []


def test_an_empty_recording_is_a_bag(tmp_path):
    write(tmp_path / "run", [])
    assert summarise_bag(tmp_path / "run")[0].messages == 0
    assert bag_length(tmp_path / "run") == 0.0


def test_nothing_is_overwritten(tmp_path):
    write(tmp_path / "run", [1])
    with pytest.raises(BagError, match="exists already"):
        Recorder(tmp_path / "run", PROFILE)


def test_a_place_that_cannot_be_written(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(BagError, match=r"cannot write a bag at .*choose another place"):
        Recorder(tmp_path / "file" / "run", PROFILE)


def test_only_this_user_may_look_into_a_bag(tmp_path):
    write(tmp_path / "run", [1])
    modes = {path.name: path.stat().st_mode & 0o777 for path in (tmp_path / "run").iterdir()}
    assert modes == {"run.mcap": 0o600, "metadata.yaml": 0o600}
    assert (tmp_path / "run").stat().st_mode & 0o777 == 0o700


def test_what_does_not_fit_the_queue_is_dropped_and_counted(tmp_path):
    recorder = Recorder(tmp_path / "run", PROFILE, queue_bytes=10)
    recorder.add(Topic(STATES, []))
    put(recorder, 1)
    assert recorder.close().lost == 1


def test_what_the_profile_does_not_let_through_is_not_written_and_told(tmp_path):
    recorder = Recorder(tmp_path / "run", PROFILE)
    recorder.add(Topic(STATES, []))
    put(recorder, 1)
    put(recorder, 2, message=ArmState(reason="x" * 400))
    recorder.put(Stored(STATES, 1, b"\x00\x01\x00\x00picture"))
    summary = recorder.close()
    assert (summary.messages, summary.refused) == (1, 2)
    assert recorder.verdict().level == Level.WARN
    assert "does not let through: /arm_state: " in recorder.verdict().message
    assert [topic.messages for topic in summarise_bag(tmp_path / "run")] == [1]
    assert notes_of(tmp_path / "run") == {LOST: "0", REFUSED: "2"}


def test_the_definitions_of_all_our_types_are_known():
    assert {STATES.message_type, "bathbot_msgs/msg/SimContact", "vision_msgs/msg/Detection2DArray",
            "realsense2_camera_msgs/msg/Extrinsics"} <= set(installed_types().fielddefs)  # fmt: skip


@pytest.mark.graph
def test_of_a_killed_recorder_all_topics_can_be_read_in_order_of_time(tmp_path):
    topics = ("left", "right", "up")
    with started({}, tmp_path / "logs", "talker") as graph:
        publishers = [
            graph.client.node.create_publisher(ArmState, f"{name}/arm_state", 50) for name in topics
        ]
        recorder = graph.start("recorder", {"bag": tmp_path / "bag"})
        graph.wait_until_active()
        heard = lambda: all(one.get_subscription_count() for one in publishers)  # noqa: E731
        assert graph.client.spin_until(heard, 5.0)
        for count in range(300):
            for publisher in publishers:
                publisher.publish(state(count))
            time.sleep(0.005)
        recorder.process.kill()
        recorder.process.wait()
        graph.group.children.remove(recorder)
    times = [entry.time for entry in read_messages(tmp_path / "bag", ("arm_state",))]
    assert len(times) > 3 * 100
    assert times == sorted(times)


@pytest.mark.graph
def test_seconds_count_from_the_first_message_of_somebody_else(tmp_path, monkeypatch):
    with started({}, tmp_path / "logs", "talker") as graph:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(graph.domain))
        states = graph.client.node.create_publisher(ArmState, "arm_state", 10)
        over, sent = threading.Event(), []

        def talk():
            while not over.wait(0.02):
                if states.get_subscription_count():
                    if not sent:
                        time.sleep(2.0)  # the recorder has been there for long
                    sent.append(time.monotonic())
                    states.publish(state(len(sent)))

        talker = threading.Thread(target=talk)
        talker.start()
        try:
            record_graph(tmp_path / "bag", "metrics_only", Consent(), 1.0)
        finally:
            over.set()
            talker.join()
    found = [entry.time for entry in read_messages(tmp_path / "bag", ("arm_state",))]
    assert 0.9e9 < found[-1] - found[0] < 4e9


@pytest.mark.graph
def test_where_nobody_speaks_there_is_nothing_to_count_from_and_no_bag(tmp_path, monkeypatch):
    """Beside a bag of another day, whose messages count for nothing."""
    write(tmp_path / "old.mcap", [1, 2])
    monkeypatch.setenv("ROS_DOMAIN_ID", str(free_domain(os.getpid() + 2, used_ports())))
    with pytest.raises(BagError, match="nothing that the profile metrics_only lets through came within 4 s"):
        record_graph(tmp_path / "new.mcap", "metrics_only", Consent(), 1.0, patience=4.0)
    assert {file.name for file in tmp_path.iterdir()} == {"old.mcap", "metadata.yaml"}


@pytest.mark.graph
def test_an_interrupted_recorder_closes_its_bag(tmp_path):
    """Ctrl-C of the command line: the bag is whole and listed."""
    environment = isolated_environment(free_domain(os.getpid() + 1, used_ports()), tmp_path)
    command = [sys.executable, "-m", "bathbot_bringup.command.cli", "record", "--out", str(tmp_path / "bag")]
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        deadline = time.monotonic() + 20.0
        while not (tmp_path / "bag").exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20.0)
    assert (process.returncode, err) == (0, "")
    assert "wrote" in out
    assert summarise_bag(tmp_path / "bag")


def until(condition):
    deadline = time.monotonic() + 10.0
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_a_full_disk_is_told_at_once_and_what_fits_later_is_written(tmp_path, monkeypatch):
    recorder, full = Recorder(tmp_path / "bag", PROFILE), threading.Event()
    really = os.pwrite

    def pwrite(*arguments):
        if full.is_set():
            raise OSError(errno.ENOSPC, "No space left on device")
        return really(*arguments)

    monkeypatch.setattr(os, "pwrite", pwrite)
    recorder.add(Topic(STATES, []))
    assert recorder.verdict() == (Level.OK, "recording profile metrics_only")
    put(recorder, 0)
    until(lambda: recorder.messages == 1)
    full.set()
    until(lambda: recorder.failure)
    for count in range(1, 4):
        put(recorder, count, stamp=2)
    until(lambda: recorder.dropped == 3)
    assert recorder.verdict() == (Level.ERROR, "the bag lacks 3 messages so far: No space left on device")
    full.clear()
    until(lambda: not recorder.failure)
    put(recorder, 4, stamp=3)
    assert recorder.close()[1:3] == (2, 3)
    assert [entry.message.path_id for entry in read_messages(tmp_path / "bag", ("arm_state",))] == [0, 4]


def test_a_folder_that_is_gone_is_told(tmp_path):
    recorder = Recorder(tmp_path / "bag", PROFILE)
    recorder.add(Topic(STATES, []))
    shutil.rmtree(tmp_path / "bag")
    put(recorder, 0)
    until(lambda: recorder.failure)
    with pytest.raises(BagError, match=r"lacks .*No such file or directory"):
        recorder.close()
