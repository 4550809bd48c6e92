"""Frames, units and datagrams of the controller's protocol."""

import itertools
import json

import numpy as np
import pytest
from bathbot_scrub.arm.errors import ProtocolError
from bathbot_scrub.rm65.controller import protocol
from bathbot_scrub.rm65.controller.protocol import FrameBuffer, decode, encode, integer, integers
from bathbot_scrub.rm65.controller.state_push import parse_sample
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

values = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**9), 10**9) | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=8,
)
frames = st.dictionaries(st.text(max_size=10), values, max_size=5)


def pieces(data, cuts):
    edges = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    return [data[a:b] for a, b in itertools.pairwise(edges)]


@given(sent=st.lists(frames, max_size=4), cuts=st.lists(st.integers(0, 10**6), max_size=8))
def test_frames_survive_any_cutting(sent, cuts):
    buffer = FrameBuffer()
    stream = b"".join(encode(frame) for frame in sent)
    assert [frame for piece in pieces(stream, cuts) for frame in buffer.feed(piece)] == sent


@given(noise=st.binary(max_size=300), cuts=st.lists(st.integers(0, 300), max_size=4), after=frames)
def test_garbage_never_raises_and_the_stream_goes_on(noise, cuts, after):
    buffer = FrameBuffer()
    for piece in pieces(noise, cuts):
        for frame in buffer.feed(piece):
            assert isinstance(frame, dict | ProtocolError)
    last = list(buffer.feed(b"\r\n" + encode(after)))[-1]
    assert last == after


def test_bare_line_feeds_belong_to_the_frame():
    pretty = json.dumps({"command": "movec", "pose": [1, 2]}, indent="\t").encode() + b"\r\n"
    assert list(FrameBuffer().feed(pretty)) == [{"command": "movec", "pose": [1, 2]}]


def test_a_frame_without_end_closes_the_stream():
    buffer = FrameBuffer(limit=100)
    with pytest.raises(ProtocolError, match="no end of frame"):
        list(buffer.feed(b"x" * 101))


def test_a_long_frame_is_refused_and_skipped():
    long, short = encode({"text": "x" * 200}), encode({"ok": 1})
    first, second = FrameBuffer(limit=150).feed(long + short)
    assert isinstance(first, ProtocolError)
    assert second == {"ok": 1}


@pytest.mark.parametrize(
    "raw",
    [
        pytest.param(b"\xff\xfe{}", id="not UTF-8"),
        pytest.param(b"{", id="not JSON"),
        pytest.param(b"[1]", id="no object"),
        pytest.param(b'{"a": NaN}', id="NaN"),
        pytest.param(b"[" * 20000, id="deep"),
    ],
)
def test_bad_frames_are_refused(raw):
    with pytest.raises(ProtocolError):
        decode(raw)


@pytest.mark.parametrize(
    "bad", [None, [1] * 5, [1] * 7, ["1"] * 6, [True] * 6, [1e300] * 6, [float("nan")] * 6, "123456"]
)
def test_six_numbers_are_six_sane_numbers(bad):
    with pytest.raises(ProtocolError, match="joint"):
        integers({"joint": bad}, "joint", 6)


@pytest.mark.parametrize("bad", [None, "5", True, 0, 101, float("nan")])
def test_a_number_keeps_its_range(bad):
    with pytest.raises(ProtocolError, match="from 1 to 100"):
        integer({"v": bad}, "v", 1, 100)


@given(joints=st.lists(st.floats(-6.3, 6.3), min_size=6, max_size=6))
def test_joints_survive_to_half_a_step(joints):
    assert_allclose(
        protocol.joints_from_wire(protocol.joints_to_wire(joints)), joints, atol=np.radians(0.0005) + 1e-12
    )


def test_wire_units_by_hand():
    assert protocol.joints_to_wire(np.radians([0, 20, 70, 0, 90, 0])) == [0, 20000, 70000, 0, 90000, 0]
    assert protocol.wrench_to_wire([1.5, 0, 0, 0, 0, -0.25]) == [1500, 0, 0, 0, 0, -250]
    T = np.eye(4)
    T[:3, 3] = 0.1, -0.2, 0.3
    assert protocol.pose_to_wire(T) == [100000, -200000, 300000, 0, 0, 0]
    assert protocol.quaternion_to_wire(np.eye(3)) == [1000000, 0, 0, 0]


@given(angles=st.tuples(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1)))
def test_poses_survive_and_euler_angles_are_rz_ry_rx(angles):
    rotation = protocol.rotation_from_euler(angles)
    assert_allclose(rotation, Rotation.from_euler("xyz", angles).as_matrix(), atol=1e-12)
    assert_allclose(protocol.rotation_from_euler(protocol.euler_from_rotation(rotation)), rotation, atol=1e-9)
    assert_allclose(protocol.quaternion_from_wire(protocol.quaternion_to_wire(rotation)), rotation, atol=1e-5)


@pytest.mark.parametrize("pitch", [90.0, -90.0, 89.9999999])
@given(roll=st.floats(-3.1, 3.1), yaw=st.floats(-3.1, 3.1))
def test_a_flange_on_its_side_is_told_by_angles_that_turn_it_so(pitch, roll, yaw):
    rotation = Rotation.from_euler("xyz", (roll, np.radians(pitch), yaw)).as_matrix()
    assert_allclose(protocol.rotation_from_euler(protocol.euler_from_rotation(rotation)), rotation, atol=1e-7)


@given(wire=st.tuples(*4 * [st.integers(-1_000_000, 1_000_000)]))
def test_a_quaternion_of_any_length_turns_as_it_does_by_scipy(wire):
    assume(np.linalg.norm(wire) > 0.6e6)
    expected = Rotation.from_quat(np.roll(wire, -1)).as_matrix()
    assert_allclose(protocol.quaternion_from_wire(wire), expected, atol=1e-12)


def test_zero_quaternion_is_refused():
    with pytest.raises(ProtocolError, match="unit length"):
        protocol.quaternion_from_wire([0, 0, 0, 0])


def push(**changes):
    state = {
        "state": "realtime_arm_joint_state",
        "arm_current_status": "idle",
        "err": [0],
        "arm_err": 0,
        "sys_err": 0,
        "joint_status": {"joint_position": [0, 20000, 70000, 0, 90000, 0]},
        "six_force_sensor": {"force": [0] * 6, "zero_force": [1500, 0, -2000, 10, 0, 0]},
        "waypoint": {"position": [100000, 0, 300000], "euler": [0, 0, 0], "quat": [1000000, 0, 0, 0]},
    }
    return json.dumps(state | changes).encode()


def test_a_push_becomes_a_sample_in_si_units():
    sample = parse_sample(push() + b"\r\n", 12.5)
    assert sample.stamp == 12.5
    assert_allclose(np.degrees(sample.joints), [0, 20, 70, 0, 90, 0])
    assert_allclose(sample.wrench, [1.5, 0, -2, 0.01, 0, 0])
    assert_allclose(sample.T_base_flange[:3, 3], [0.1, 0, 0.3])
    assert sample.errors == ()


@pytest.mark.parametrize(
    ("changes", "codes"),
    [
        pytest.param({"err": [0], "arm_err": 4109}, (4109,), id="arm_err"),
        pytest.param({"err": [4109, 3], "arm_err": 4109}, (4109, 3), id="list"),
        pytest.param({"err": 5}, (5,), id="number"),
        pytest.param({"err": ["0x100D"]}, (4109,), id="text"),
        pytest.param({"err": [None]}, (-1,), id="unreadable"),
    ],
)
def test_error_codes_are_read_in_every_shape(changes, codes):
    assert parse_sample(push(**changes), 0.0).errors == codes


@pytest.mark.parametrize("part", ["joint_status", "six_force_sensor", "waypoint", "state"])
def test_an_incomplete_push_is_refused(part):
    with pytest.raises(ProtocolError):
        parse_sample(push(**{part: None}), 0.0)


@given(noise=st.binary(max_size=200))
def test_any_datagram_is_a_sample_or_an_error(noise):
    with pytest.raises(ProtocolError):
        parse_sample(noise, 0.0)
