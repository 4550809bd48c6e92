"""Clients that come, go, stay silent, break off or are hostile: none is kept, none does harm."""

import contextlib
import json
import logging
import os
import socket
import struct
import threading
import time

import numpy as np
import pytest
from bathbot_bringup.sim.arm.commands.table import COMMANDS, reply
from bathbot_bringup.sim.arm.emulator.emulator import Emulator, is_loopback
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.controller.protocol import FrameBuffer, encode
from command_examples import EXAMPLES, JOINTS, READY, desk_at, run
from emulator_cell import until
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

pytestmark = pytest.mark.graph

LENIENT = settings(
    deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
HOSTILE = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**30), 10**30),
    st.sampled_from([2**31, -(2**31), 10**300, 0, -1, 7, 101]),
    st.floats(),
    st.text(max_size=5),
    st.sampled_from(["", "\ud800", "x" * 500, "127.0.0.1", "0", "pos", "joint"]),
    st.lists(st.integers(-(2**40), 2**40) | st.floats() | st.text(max_size=2) | st.none(), max_size=8),
    st.dictionaries(st.sampled_from(["pose_via", "pose_to", "joint_speed", "x"]), st.integers(), max_size=3),
)


@pytest.fixture(scope="module")
def emulator():
    with Emulator(EmulatorSettings(port=0, joints_deg=tuple(np.degrees(READY)))) as emulator:
        yield emulator


def connect(emulator, timeout=10.0):
    return socket.create_connection(("127.0.0.1", emulator.port), timeout=timeout)


def ask(client, frame, buffer=None):
    """Send a frame and give the next one that comes."""
    client.sendall(encode(frame))
    buffer = buffer or FrameBuffer()
    while True:
        for answer in buffer.feed(client.recv(65536)):
            return answer


def works(emulator):
    """Answers a new client, and stands at numbers."""
    with connect(emulator) as client:
        return np.isfinite(ask(client, {"command": "get_joint_degree"})["joint"]).all()


def leave(client, way):
    """Go in one of several ways."""
    if way == "half a frame":
        client.sendall(b'{"command": "movej", "jo')
    elif way == "asks and runs":
        client.sendall(encode({"command": "get_DH_data"}) * 20)
    elif way == "reset":
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    client.close()


def test_a_hundred_clients_come_and_go_and_none_is_kept(emulator):
    works(emulator)
    until(lambda: not emulator.sessions)
    threads, files = threading.active_count(), len(os.listdir("/proc/self/fd"))
    ways = ("politely", "half a frame", "asks and runs", "reset")
    for _ in range(5):
        clients = [connect(emulator) for _ in range(20)]
        until(lambda: len(emulator.sessions) >= 20)
        for index, client in enumerate(clients):
            leave(client, ways[index % 4])
    assert works(emulator)
    until(lambda: not emulator.sessions)
    until(lambda: len(os.listdir("/proc/self/fd")) == files)
    assert threading.active_count() == threads


def test_more_clients_than_it_takes_are_sent_away(emulator):
    with contextlib.ExitStack() as stack:
        for _ in range(220):
            stack.enter_context(contextlib.closing(connect(emulator)))
        time.sleep(0.05)
        assert len(emulator.sessions) <= 200
    assert works(emulator)


@LENIENT
@given(data=st.data(), name=st.sampled_from(sorted(EXAMPLES)))
def test_any_value_in_any_field_is_granted_or_refused_in_the_protocol_s_words(data, name):
    desk = desk_at()
    request = dict(EXAMPLES[name])
    fields = sorted(set(request) - {"command"}) or ["joint"]
    for field in data.draw(st.lists(st.sampled_from(fields), min_size=1, max_size=2)):
        if isinstance(request.get(field), list) and request[field] and data.draw(st.booleans()):
            spoilt = list(request[field])
            spoilt[data.draw(st.integers(0, len(spoilt) - 1))] = data.draw(HOSTILE)
            request[field] = spoilt
        else:
            request[field] = data.draw(HOSTILE)
    answer = reply(desk, request)
    json.dumps(answer, allow_nan=False)
    refusal = COMMANDS[name].refusal
    assert answer is None or answer.get("command", answer.get("state"))
    assert (
        answer is None or not refusal or answer.get(refusal, True) in (True, False, 0, 1) or refusal == "mode"
    )
    joints, _, _ = run(desk, 0.03)
    assert np.isfinite(joints).all()
    assert RM65_LIMITS.contain(joints[-1], -1e-6)


@settings(LENIENT, max_examples=60)
@given(data=st.data(), name=st.sampled_from(sorted(set(EXAMPLES) - {"set_realtime_push"})))
def test_bytes_that_are_nearly_right_harm_nobody(emulator, data, name):
    raw = bytearray(encode(EXAMPLES[name] | {"v": 1}))
    for _ in range(data.draw(st.integers(1, 4))):
        place = data.draw(st.integers(0, len(raw) - 1))
        match data.draw(st.sampled_from(["change", "cut", "double", "insert"])):
            case "change":
                raw[place] = data.draw(st.integers(0, 255))
            case "cut":
                raw = raw[:place] or bytearray(b"{")
            case "double":
                raw = raw[:place] + raw
            case "insert":
                raw[place:place] = data.draw(
                    st.sampled_from([b"\r\n", b"NaN", b"1e999", b"[" * 900, b"\xff"])
                )
    with connect(emulator) as client, contextlib.suppress(ConnectionError):
        client.sendall(bytes(raw) + b"\r\n")
        client.sendall(encode({"command": "set_arm_stop"}))
    assert works(emulator)


@pytest.mark.parametrize(
    "frame",
    [b"[" * 60000, b'{"command":' * 3000, b'{"command":"' + b"x" * 60000 + b'"}', b"\xff\xfe", b"9" * 5000,
     b'{"command":"movej","v":1e999,"joint":[NaN]}', b'{"command":{"a":1}}', b'{"command":"\\ud800"}',
     b"null"],
)  # fmt: skip
def test_a_hostile_frame_leaves_the_connection_in_use(emulator, frame, caplog):
    with caplog.at_level(logging.WARNING), connect(emulator) as client:
        for _ in range(3):
            client.sendall(frame + b"\r\n")
        buffer, answers = FrameBuffer(), []
        client.sendall(encode({"command": "get_joint_degree"}))
        while not any("joint" in answer for answer in answers):
            answers += list(buffer.feed(client.recv(65536)))
    assert len([record for record in caplog.records if "client" in record.message]) <= 1
    assert not any(record.exc_info for record in caplog.records)


def test_after_all_that_the_arm_still_moves(emulator):
    with connect(emulator) as client:
        buffer = FrameBuffer()
        on = [{"command": "set_joint_en_state", "joint_en_state": [n, 1]} for n in range(1, 7)]
        for name in ("set_arm_stop", "clear_system_err", "set_arm_init", "set_change_tool_frame",
                     "set_change_work_frame", "set_arm_power", "set_arm_stop"):  # fmt: skip
            ask(client, EXAMPLES[name], buffer)
        for frame in on:
            ask(client, frame, buffer)
        goal = {"command": "movej", "v": 100, "joint": [8000, *JOINTS[1:]]}
        until(lambda: ask(client, goal, buffer).get("receive_state") is True)
        until(lambda: np.abs(np.degrees(emulator.truth().joints[0]) - 8.0) < 0.05)
    assert_allclose(emulator.truth().T_base_head[3], [0, 0, 0, 1])


@pytest.mark.parametrize(
    ("host", "told"),
    [("127.0.0.1", True), ("::1", True), ("localhost", True), ("0.0.0.0", False), ("x", False)],
)
def test_only_loopback_is_taken_for_private(host, told):
    assert is_loopback(host) is told


def test_listening_to_the_world_is_told(caplog):
    with caplog.at_level(logging.WARNING), Emulator(EmulatorSettings(host="0.0.0.0", port=0)):
        pass
    assert "whoever reaches it may move its arm" in caplog.text
