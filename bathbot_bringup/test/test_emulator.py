"""The emulated controller over real TCP and UDP on free ports."""

import socket
import threading
import time

import numpy as np
import pytest
from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_scrub.arm.errors import ArmConnectionError, ArmSettingsError, RefusedError
from bathbot_scrub.rm65.arm.limits import HOME_DEG
from bathbot_scrub.rm65.arm.rm65 import RM65
from bathbot_scrub.rm65.controller.client import TRAJECTORY_EVENT, ArmClient
from bathbot_scrub.rm65.controller.protocol import FrameBuffer, encode, joints_from_wire
from bathbot_scrub.rm65.controller.state_push import StateReceiver
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

pytestmark = pytest.mark.graph


def until(condition, timeout=15.0):
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, "not in time"
        time.sleep(0.005)


@pytest.fixture(scope="module")
def emulator():
    with Emulator(EmulatorSettings(port=0)) as emulator:
        yield emulator


@pytest.fixture
def client(emulator):
    events = []
    client = ArmClient("127.0.0.1", emulator.port, on_event=events.append)
    client.events = events
    client.start()
    until(lambda: client.connection.connected)
    yield client
    client.close()


@pytest.fixture
def samples(client):
    samples = []
    receiver = StateReceiver(0, samples.append)
    receiver.expect("127.0.0.1")
    client.demand({"command": "set_realtime_push", "cycle": 1, "enable": True, "port": receiver.port,
                   "ip": "127.0.0.1"}, "state")  # fmt: skip
    until(lambda: samples)
    yield samples
    assert receiver.rejected == 0
    receiver.close()


def alive(emulator):
    """Answers a new client."""
    with socket.create_connection(("127.0.0.1", emulator.port), timeout=10.0) as probe:
        probe.sendall(encode({"command": "get_joint_degree"}))
        buffer = FrameBuffer()
        return any("joint" in frame for frame in buffer.feed(probe.recv(4096)))


def test_a_moved_arm_says_so_once_on_tcp_and_all_along_on_udp(client, samples):
    goal = [5000, 60000, -125000, 0, -80000, 0]
    client.demand(
        {"command": "movej", "v": 60, "joint": goal, "trajectory_connect": 0, "r": 0}, "receive_state"
    )
    until(lambda: client.events)
    time.sleep(0.1)
    assert client.events == [
        {"state": TRAJECTORY_EVENT, "trajectory_state": True, "device": 0, "trajectory_connect": 0}
    ]
    assert_allclose(samples[-1].joints, joints_from_wire(goal), atol=2e-4)
    assert "move_J" in {sample.status for sample in samples}
    with pytest.raises(RefusedError):
        client.demand({"command": "movej", "v": 60, "joint": [179000, 0, 0, 0, 0, 0]}, "receive_state")


def test_the_stream_arrives(client, samples):
    joints = samples[-1].joints.copy()
    for _ in range(40):
        joints[5] += 0.01
        client.stream_joints(joints)
        time.sleep(0.01)
    until(lambda: abs(samples[-1].joints[5] - joints[5]) < 1e-4)
    assert "move_through_joint" in {sample.status for sample in samples}


def test_the_push_comes_steadily_and_can_be_slowed(client, samples):
    begin = len(samples)
    time.sleep(0.5)
    fast = len(samples) - begin
    client.demand({"command": "set_realtime_push", "cycle": 10}, "state")
    begin = len(samples)
    time.sleep(0.5)
    assert fast > 3 * (len(samples) - begin) > 0
    assert client.request({"command": "get_realtime_push"})["cycle"] == 10


def test_zeroed_force_is_noise(client, samples):
    client.demand({"command": "clear_force_data"}, "clear_state")
    time.sleep(0.1)
    begin = len(samples)
    until(lambda: len(samples) > begin + 20)
    assert np.abs(np.mean([sample.wrench[:3] for sample in samples[begin:]], axis=0)).max() < 0.1


@given(noise=st.binary(max_size=400))
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_no_bytes_kill_it(emulator, noise):
    with socket.create_connection(("127.0.0.1", emulator.port), timeout=5.0) as hostile:
        hostile.sendall(noise + b"\r\n")
    assert alive(emulator)


def test_an_endless_frame_is_cut_off(emulator):
    with socket.create_connection(("127.0.0.1", emulator.port), timeout=10.0) as hostile:
        try:
            for _ in range(40):
                hostile.sendall(b"x" * 8192)
            assert hostile.recv(1) == b""
        except ConnectionError:
            pass
    assert alive(emulator)


def test_one_who_asks_and_never_reads_harms_nobody(emulator):
    with socket.create_connection(("127.0.0.1", emulator.port), timeout=0.5) as greedy:
        question = encode({"command": "get_DH_data"}) * 2000
        try:
            for _ in range(20):
                greedy.sendall(question)
        except OSError:
            pass
    assert alive(emulator)


def test_many_clients_come_and_go_and_none_is_kept(emulator):
    before = threading.active_count()
    for _ in range(100):
        socket.create_connection(("127.0.0.1", emulator.port), timeout=5.0).close()
    assert alive(emulator)
    until(lambda: not emulator.sessions)
    assert threading.active_count() == before


def test_truth_is_where_the_joints_are(emulator):
    truth = emulator.truth()
    assert_allclose(truth.T_base_head, RM65("6F").head(truth.joints), atol=1e-3)
    assert truth.contact.part == ""


def test_a_taken_port_is_one_clear_line(emulator):
    with pytest.raises(ArmConnectionError, match="choose another host or port") as caught:
        Emulator(EmulatorSettings(port=emulator.port))
    assert "\n" not in str(caught.value)
    with pytest.raises(ArmConnectionError):
        Emulator(EmulatorSettings(host="no such host", port=0))


@pytest.mark.parametrize(
    "change", [{"port": -1}, {"udp_port": 0}, {"variant": "X"}, {"generation": 2}, {"joints_deg": (0.0,)}]
)
def test_meaningless_settings_are_refused(change):
    with pytest.raises(ArmSettingsError):
        EmulatorSettings(**change)


def test_it_begins_at_home_and_closing_twice_is_fine():
    emulator = Emulator(EmulatorSettings(port=0))
    assert_allclose(np.degrees(emulator.truth().joints), HOME_DEG)
    emulator.close()
    emulator.close()
