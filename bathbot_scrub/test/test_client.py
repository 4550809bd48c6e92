"""The TCP client against a small scripted server, and the UDP receiver."""

import queue
import socket
import threading
import time

import pytest
from bathbot_scrub.arm.errors import ArmConnectionError, RefusedError
from bathbot_scrub.rm65.controller.client import ArmClient
from bathbot_scrub.rm65.controller.protocol import FrameBuffer, encode
from bathbot_scrub.rm65.controller.state_push import StateReceiver
from test_protocol import push

pytestmark = pytest.mark.graph


def until(condition, timeout=5.0):
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, "not in time"
        time.sleep(0.005)


class Server:
    """Answers each frame by a function from frame to bytes; can cut its clients off."""

    def __init__(self, answer, port=0):
        self.answer, self.heard, self.clients = answer, queue.Queue(), []
        self.socket = socket.create_server(("127.0.0.1", port))
        self.port = self.socket.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            try:
                client, _ = self.socket.accept()
            except OSError:
                return
            self.clients.append(client)
            threading.Thread(target=self.serve, args=(client,), daemon=True).start()

    def serve(self, client):
        buffer = FrameBuffer()
        while True:
            try:
                data = client.recv(4096)
                if not data:
                    return
                for frame in buffer.feed(data):
                    self.heard.put(frame)
                    client.sendall(self.answer(frame))
            except OSError:
                return

    def cut(self):
        for client in self.clients:
            client.shutdown(socket.SHUT_RDWR)
        self.clients.clear()

    def close(self):
        self.cut()
        self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()


@pytest.fixture
def connect():
    open_things = []

    def make(answer=lambda frame: encode({"command": frame["command"], "ok": True}), **callbacks):
        server = Server(answer)
        client = ArmClient("127.0.0.1", server.port, **callbacks)
        client.start()
        open_things.append((client, server))
        until(lambda: client.connection.connected)
        return client, server

    yield make
    for client, server in open_things:
        client.close()
        server.close()


def test_replies_are_matched_by_name_and_the_rest_are_events(connect):
    events = []
    event = {"state": "current_trajectory_state", "trajectory_state": True}
    client, _ = connect(
        lambda frame: encode(event) + encode({"state": "joint_degree", "joint": [1]}), on_event=events.append
    )
    assert client.request({"command": "get_joint_degree"})["joint"] == [1]
    assert events == [event]


def test_malformed_bytes_before_a_reply_are_skipped_and_counted(connect):
    client, _ = connect(
        lambda frame: b"\xff{not json\r\n[1]\r\n" + encode({"command": frame["command"], "ok": 1})
    )
    assert client.request({"command": "x"})["ok"] == 1
    assert client.protocol_errors == 2


def test_no_reply_is_an_error_in_time_and_the_next_request_works(connect):
    client, _ = connect(
        lambda frame: b"" if frame["command"] == "deaf" else encode({"command": frame["command"]})
    )
    with pytest.raises(ArmConnectionError, match="no reply to deaf"):
        client.request({"command": "deaf"}, timeout=0.1)
    assert client.request({"command": "x"}) == {"command": "x"}


def test_refusal_shows_the_answer(connect):
    client, _ = connect(lambda frame: encode({"command": frame["command"], "receive_state": False}))
    with pytest.raises(RefusedError, match="refused movej"):
        client.demand({"command": "movej"}, "receive_state")


def test_a_query_is_answered_by_the_name_of_the_state(connect):
    client, _ = connect(lambda frame: encode({"state": "install_pose", "pose": [0, 0, 0]}))
    assert client.request({"command": "get_install_pose"})["pose"] == [0, 0, 0]


def test_giving_up_a_connection_builds_a_new_one(connect):
    told = []
    client, _ = connect(on_connection=told.append)
    assert client.controller_address() == client.local_address() == "127.0.0.1"
    client.reconnect()
    until(lambda: len(told) >= 3 and told[-1].connected)
    assert client.request({"command": "x"})["ok"]


def test_many_threads_get_their_own_replies(connect):
    client, _ = connect(lambda frame: encode({"command": frame["command"], "echo": frame["number"]}))
    wrong = []

    def ask(name):
        for number in range(20):
            if client.request({"command": name, "number": number})["echo"] != number:
                wrong.append((name, number))

    threads = [threading.Thread(target=ask, args=(f"c{i}",)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10.0)
    assert wrong == []


def test_the_stream_is_the_vendors_frame(connect):
    client, server = connect(lambda frame: b"")
    client.stream_joints([0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
    frame = server.heard.get(timeout=5.0)
    assert frame == {
        "command": "movej_canfd",
        "joint": [0, 5730, 0, 0, 0, 0],
        "follow": True,
        "expand": 0,
        "trajectory_mode": 0,
        "radio": 0,
    }


def test_a_lost_connection_is_told_and_built_up_again(connect):
    told = []
    client, server = connect(on_connection=told.append)
    assert client.request({"command": "x"})["ok"]  # the server has accepted the connection it shall cut
    server.cut()
    until(lambda: len(told) >= 3 and told[-1].connected, timeout=15.0)
    assert not told[1].connected
    assert "lost the controller" in told[1].reason
    assert client.request({"command": "x"})["ok"]


def test_loss_while_waiting_ends_the_wait(connect):
    client, server = connect(lambda frame: b"")
    threading.Timer(0.1, server.cut).start()
    with pytest.raises(ArmConnectionError):
        client.request({"command": "x"}, timeout=5.0)


@pytest.mark.parametrize("host", ["127.0.0.1", "no such host", "\u2603.invalid"])
def test_a_wrong_address_is_one_clear_line_told_once(host):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
    told = []
    client = ArmClient(host, port, on_connection=told.append)
    client.start()
    until(lambda: told)
    time.sleep(0.5)
    client.close()
    assert len(told) == 1
    assert "check parameters host and port" in told[0].reason
    assert "\n" not in told[0].reason
    with pytest.raises(ArmConnectionError):
        client.request({"command": "x"})


def test_receiver_keeps_the_newest_sample_and_counts_the_rest():
    samples = []
    receiver = StateReceiver(0, samples.append, learn=0.0)
    receiver.expect("127.0.0.1")
    assert receiver.age() == float("inf")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for data in (b"noise", push(), b"\xff" * 9000, push(arm_current_status="move_J")):
            sender.sendto(data, ("127.0.0.1", receiver.port))
        until(lambda: len(samples) == 2)
    assert receiver.latest.status == "move_J"
    assert (receiver.accepted, receiver.rejected) == (2, 2)
    assert 0.0 <= receiver.age() < 5.0
    receiver.close()


def test_receiver_listens_where_the_controller_sends_to_and_nowhere_else():
    samples = []
    receiver = StateReceiver(0, samples.append, learn=0.0)
    receiver.expect("127.0.0.1")
    receiver.listen_at("127.0.0.3")
    receiver.listen_at("127.0.0.2")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(push(), ("127.0.0.2", receiver.port))
        until(lambda: len(samples) == 1)
        for elsewhere in ("127.0.0.1", "127.0.0.3"):
            sender.sendto(push(), (elsewhere, receiver.port))
        sender.sendto(push(arm_current_status="move_J"), ("127.0.0.2", receiver.port))
        until(lambda: samples[-1].status == "move_J")
    assert len(samples) == 2
    receiver.close()


def test_receiver_refuses_strangers_and_a_taken_port():
    samples = []
    receiver = StateReceiver(0, samples.append, learn=0.0)
    receiver.expect("192.0.2.7")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(push(), ("127.0.0.1", receiver.port))
        until(lambda: receiver.rejected == 1)
    assert "not from the controller" in receiver.last_error
    with pytest.raises(ArmConnectionError, match="choose another udp_port"):
        StateReceiver(receiver.port, samples.append)
    receiver.close()
