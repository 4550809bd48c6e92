"""Hostile bytes: every reader of the wire refuses them in its own words, counts them and goes on."""

import json
import socket
import threading
import time

import numpy as np
import pytest
from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.rm65.controller.client import ArmClient
from bathbot_scrub.rm65.controller.protocol import FrameBuffer, decode, encode
from bathbot_scrub.rm65.controller.state_push import StateReceiver, parse_sample
from hypothesis import given, settings
from hypothesis import strategies as st

GOOD = {
    "state": "realtime_arm_joint_state",
    "arm_current_status": "idle",
    "err": [0],
    "joint_status": {"joint_position": [0] * 6, "joint_err_code": [0] * 6, "joint_en_flag": [1] * 6},
    "six_force_sensor": {"zero_force": [1, 2, 3, 4, 5, 6]},
    "waypoint": {"position": [0, 0, 879000], "quat": [0, 0, 0, 1000000]},
}
numbers = st.integers() | st.floats() | st.just(10**400)
values = st.recursive(
    st.none() | st.booleans() | numbers | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=8) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=12,
)
keys = st.sampled_from([key for key in GOOD if key != "state"])


@given(pieces=st.lists(st.binary(max_size=60) | st.just(b"\r\n") | st.just(b'{"a":1}\r\n'), max_size=20))
def test_a_stream_of_any_bytes_gives_frames_and_errors_and_never_raises_below_the_limit(pieces):
    buffer = FrameBuffer()
    whole = [item for piece in pieces for item in buffer.feed(piece)]
    assert all(isinstance(item, dict | ProtocolError) for item in whole)
    # however the bytes are cut, the same comes out
    other = FrameBuffer()
    single = [item for byte in b"".join(pieces) for item in other.feed(bytes([byte]))]
    assert [type(item) for item in single] == [type(item) for item in whole]
    *_, last = *buffer.feed(b'\r\n{"after":1}\r\n'), None
    assert list(FrameBuffer().feed(encode({"after": 1}))) == [{"after": 1}]
    assert last is None


@given(size=st.integers(101, 1000))
def test_a_frame_without_end_is_given_up(size):
    buffer = FrameBuffer(100)
    with pytest.raises(ProtocolError, match="no end of frame"):
        list(buffer.feed(b"x" * size))
    assert list(buffer.feed(b'{"a":1}\r\n')) == [{"a": 1}]


@given(raw=st.binary(max_size=200) | values.map(lambda value: json.dumps(value).encode()))
def test_decode_gives_an_object_or_a_protocol_error(raw):
    told = ""
    try:
        assert isinstance(decode(raw), dict)
    except ProtocolError as error:
        told = str(error)
    assert "\n" not in told


@given(key=keys, value=values)
@settings(max_examples=300)
def test_a_datagram_with_anything_in_one_place_is_a_sound_sample_or_refused(key, value):
    try:
        sample = parse_sample(json.dumps(GOOD | {key: value}).encode(), 1.0)
    except ProtocolError:
        return
    assert np.isfinite(sample.joints).all()
    assert np.isfinite(sample.T_base_flange).all()
    assert all(isinstance(code, int) for code in (*sample.errors, *sample.joint_errors))


@given(inner=st.dictionaries(st.sampled_from(["joint_position", "joint_err_code", "joint_en_flag"]), values))
@settings(max_examples=200)
def test_anything_among_the_joints_is_a_sound_sample_or_refused(inner):
    try:
        sample = parse_sample(json.dumps(GOOD | {"joint_status": GOOD["joint_status"] | inner}).encode(), 1.0)
    except ProtocolError:
        return
    assert np.isfinite(sample.joints).all()
    assert all(0 <= code <= 0xFFFF for code in sample.joint_errors)


@pytest.mark.parametrize("force", ["[null,0,0,0,0,0]", "[NaN,0,0,0,0,0]", "null", "[1e999,0,0,0,0,0]", '"x"'])
def test_a_force_that_is_no_number_leaves_the_joints_as_they_are(force):
    raw = json.dumps(GOOD).replace("[1, 2, 3, 4, 5, 6]", force).encode()
    sample = parse_sample(raw, 1.0)
    assert np.isnan(sample.wrench).all()
    assert (sample.joints == 0.0).all()


def test_joints_that_are_no_numbers_are_refused():
    raw = json.dumps(GOOD).replace(
        '"joint_position": [0, 0, 0, 0, 0, 0]', '"joint_position": [NaN,0,0,0,0,0]'
    )
    with pytest.raises(ProtocolError, match="joint_position"):
        parse_sample(raw.encode(), 1.0)


def until(condition):
    deadline = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < deadline, "not in time"
        time.sleep(0.005)


def hostile(seed):
    """Bytes of every kind a broken peer may send."""
    rng = np.random.default_rng(seed)
    return [
        rng.integers(0, 256, 3000, dtype=np.uint8).tobytes() + b"\r\n",
        b"\xff\xfe{\r\n",
        b"[" * 5000 + b"\r\n",
        b'{"command":null,"state":{}}\r\n',
        b'{"command":["x"]}\r\n{"state":1e999}\r\n',
        encode({"state": "current_trajectory_state", "trajectory_state": "perhaps"}),
    ]


@pytest.mark.graph
def test_a_peer_that_sends_garbage_is_refused_counted_and_still_answers():
    server, log = socket.create_server(("127.0.0.1", 0)), []
    client = ArmClient("127.0.0.1", server.getsockname()[1], log.append)
    client.start()
    peer, _ = server.accept()
    until(lambda: client.connection.connected)
    for data in hostile(0):
        peer.sendall(data)
    until(lambda: client.protocol_errors >= 3)

    def answer():
        peer.recv(1000)
        peer.sendall(b"\x00\r\n" + encode({"command": "get_x", "ok": True}))

    thread = threading.Thread(target=answer)
    thread.start()
    assert client.request({"command": "get_x"}, timeout=5.0)["ok"] is True
    thread.join()
    assert [connection.connected for connection in log] == [True]
    peer.sendall(b"x" * 100_000)  # no end of frame: this connection is given up, and built up again
    again, _ = server.accept()
    until(lambda: client.connection.connected)
    assert any("no end of frame" in connection.reason for connection in log)
    for end in (peer, again, server):
        end.close()
    client.close()


@pytest.mark.graph
def test_a_flood_of_garbage_datagrams_is_counted_and_hides_no_sample():
    samples, refused = [], []
    receiver = StateReceiver(0, samples.append, lambda: refused.append(1), learn=0.0)
    receiver.expect("127.0.0.1")
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    for data in [*hostile(1), b"", b"{}", json.dumps(GOOD).encode(), b"\x00" * 60000]:
        sender.sendto(data, ("127.0.0.1", receiver.port))
    until(lambda: receiver.rejected >= 9)
    until(lambda: samples)
    assert len(refused) == receiver.rejected
    assert samples[0].joint_errors == (0,) * 6
    sender.close()
    receiver.close()
