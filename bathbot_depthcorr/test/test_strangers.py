"""Another user, or another network namespace, sees no topic, hears no picture, calls no service."""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from contextlib import contextmanager
from pathlib import Path

import pytest
from bathbot_depthcorr.node.dds import reach, shared_memory, transport

pytestmark = pytest.mark.graph
DOMAIN = 58
NOBODY = 65534
MARK = b"a person in the bath"
KINDS = ("shared", "udp")  # nodes with shared memory and without
OURS = f"""
import os, sys
from bathbot_depthcorr.node.dds import transport
os.environ.update(transport.variables())
if sys.argv[1] == "udp":
    transport.keep_clear_of_shared_memory()
import rclpy
from dataclasses import dataclass
from bathbot_depthcorr.node.stage_node import StageNode
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
def stop(request, response):
    print("called", flush=True)
    return response
rclpy.init()
node = StageNode(sys.argv[1], dataclass(frozen=True)(type("Settings", (), dict())))
voice = node.create_publisher(Image, "~/picture", qos_profile_sensor_data)
service = node.create_service(Trigger, "~/stop", stop)
print("ready", flush=True)
while True:
    voice.publish(Image(data={MARK!r} * 1000))
    rclpy.spin_once(node, timeout_sec=0.05)
"""
OTHER = """
import json, os, sys, time
import rclpy
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
rclpy.init()
node = rclpy.create_node("other")
kinds, end = sys.argv[2:], time.monotonic() + float(sys.argv[1])
heard, stops, answers = set(), {}, {}
for kind in kinds:
    node.create_subscription(
        Image, kind + "/picture", lambda _, kind=kind: heard.add(kind + "/picture"), qos_profile_sensor_data
    )
    stops[kind] = node.create_client(Trigger, kind + "/stop")
def seen():
    known = [kind for kind in kinds if kind in node.get_node_names()]
    offered = [one for kind in known for one in node.get_publisher_names_and_types_by_node(kind, "/")]
    return {name[1:] for name, _ in offered if name.endswith("/picture")}
def answered():
    return {kind + "/stop" for kind, answer in answers.items() if answer.done()}
while time.monotonic() < end and not (len(heard) == len(seen()) == len(answered()) == len(kinds)):
    for kind, stop in stops.items():
        if kind not in answers and stop.service_is_ready():
            answers[kind] = stop.call_async(Trigger.Request())
    rclpy.spin_once(node, timeout_sec=0.05)
print(json.dumps([sorted(seen()), sorted(heard), sorted(answered())]))
os._exit(0)
"""
WIDER = {
    transport.RANGE: "SUBNET",
    transport.PROFILES: "mine.xml",
    "ROS_STATIC_PEERS": "192.0.2.1",
    "ROS_DISCOVERY_SERVER": "192.0.2.1:11811",
    "ROS_LOCALHOST_ONLY": "1",
}
PROFILES = Path(transport.__file__).parent
LOOPBACK_ONLY = {transport.RANGE: "SYSTEM_DEFAULT", transport.PROFILES: str(PROFILES / "fastdds_udp.xml")}
STATIC_PEER = {transport.RANGE: "SUBNET", "ROS_STATIC_PEERS": "127.0.0.1"}
HERE, THERE = "10.213.58.1", "10.213.58.2"  # ends of the cable
NEIGHBOURS = {transport.RANGE: "SUBNET", "ROS_STATIC_PEERS": f"{HERE};127.0.0.1"}
PICTURES, STOPS = (sorted(f"{kind}/{what}" for kind in KINDS) for what in ("picture", "stop"))
EVERYTHING, NOTHING = [PICTURES, PICTURES, STOPS], [[], [], []]  # seen, heard, answered


def environment(**changes):
    inherited = {name: value for name, value in os.environ.items() if name not in (*WIDER, reach.VARIABLE)}
    return inherited | {"ROS_DOMAIN_ID": str(DOMAIN), "AMENT_PREFIX_PATH": sys.prefix} | changes


@contextmanager
def ours(kind, **changes):
    node = subprocess.Popen(
        [sys.executable, "-c", OURS, kind], stdout=subprocess.PIPE, text=True, env=environment(**changes)
    )
    try:
        assert node.stdout.readline() == "ready\n"
        yield node
    finally:
        node.kill()
        node.wait()


@contextmanager
def both(**changes):
    with ours("shared", **changes) as shared, ours("udp", **changes) as udp:
        yield shared, udp


def experience(changes, *before, patience=3.0):
    """What another program sees, hears and is answered; `before` makes it a stranger."""
    told = subprocess.run(
        [*before, sys.executable, "-c", OTHER, str(patience), *KINDS], env=environment(**changes),
        stdout=subprocess.PIPE, text=True, timeout=60, check=True,
    )  # fmt: skip
    return json.loads(told.stdout.splitlines()[-1])


@pytest.fixture(autouse=True)
def nothing_of_strangers():
    """What a stranger has left in shared memory would keep the next node from its domain."""
    yield
    for path in shared_memory.FOLDER.glob("*fastrtps_*"):
        if path.stat().st_uid == NOBODY:
            path.unlink()


def as_nobody(tmp_path):
    """Another user who may read all files, for the interpreter need not be open to everybody."""
    if os.geteuid() != 0 or shutil.which("setpriv") is None:
        pytest.skip("only root can play another user, with setpriv of util-linux")
    tmp_path.chmod(0o777)
    identity = (f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups")
    reading = ("--inh-caps=+dac_read_search", "--ambient-caps=+dac_read_search")
    libraries = [os.environ.get("LD_LIBRARY_PATH", ""), sysconfig.get_config_var("LIBDIR")]
    path = f"LD_LIBRARY_PATH={os.pathsep.join(filter(None, libraries))}"  # nobody's loader heeds no rpath
    return ["env", path, f"ROS_LOG_DIR={tmp_path}", f"HOME={tmp_path}", "setpriv", *identity, *reading]


@pytest.fixture
def neighbour():
    """The beginning of a command that runs in another network namespace, joined to this one by a cable."""
    if os.geteuid() != 0 or not all(map(shutil.which, ("ip", "nsenter", "unshare"))):
        pytest.skip("only root can lay a cable to another network namespace, with iproute2 and util-linux")
    cable = (f"bath{os.getpid()}a"[-15:], f"bath{os.getpid()}b"[-15:])
    home = subprocess.Popen(["unshare", "--net", "sh", "-c", "echo; exec sleep 60"], stdout=subprocess.PIPE)
    inside = ["nsenter", "--net", f"--target={home.pid}"]
    try:
        home.stdout.readline()
        for command in (
            ["ip", "link", "add", cable[0], "type", "veth", "peer", "name", cable[1], "netns", str(home.pid)],
            ["ip", "address", "add", f"{HERE}/30", "dev", cable[0]],
            ["ip", "link", "set", cable[0], "up"],
            [*inside, "ip", "address", "add", f"{THERE}/30", "dev", cable[1]],
            [*inside, "ip", "link", "set", cable[1], "up"],
            [*inside, "ip", "link", "set", "lo", "up"],
        ):
            if (done := subprocess.run(command, capture_output=True, check=False, text=True)).returncode:
                pytest.skip(f"this machine lays no cable to another network namespace: {done.stderr}")
        yield inside
    finally:
        home.kill()  # and with its namespace the cable is gone
        home.wait()


@pytest.mark.parametrize("way", [LOOPBACK_ONLY, STATIC_PEER], ids=["loopback", "static peer"])
def test_another_user_of_this_machine_does_not(way, tmp_path):
    stranger = as_nobody(tmp_path)
    with both() as nodes:
        assert experience(way, *stranger) == NOTHING
        for node in nodes:
            node.kill()
            assert "called" not in node.stdout.read()


def test_another_user_does_where_the_reach_is_the_machine(tmp_path):
    """Which also shows that the stranger of these tests would hear."""
    stranger = as_nobody(tmp_path)
    with both(**{reach.VARIABLE: "machine"}):
        assert experience(LOOPBACK_ONLY, *stranger, patience=20.0) == EVERYTHING


@pytest.mark.parametrize("way", [LOOPBACK_ONLY, NEIGHBOURS], ids=["loopback", "static peers"])
def test_another_network_namespace_does_not(way, neighbour):
    """It is the same user, and so may open the shared memory; ROS alone lets it hear every picture."""
    with both():
        assert experience(way, *neighbour) == NOTHING


@pytest.mark.parametrize("said", [{}, WIDER], ids=["nothing", "wider"])
def test_no_socket_listens_beyond_loopback_whatever_ros_is_told(said):
    """As `ss -lnup` would show it; this user's other programs, as ROS's commands, do hear and call."""
    with both(**said) as nodes:
        assert experience({}, patience=20.0) == EVERYTHING
        folders = [Path(f"/proc/{node.pid}/fd") for node in nodes]
        links = {os.readlink(one) for folder in folders for one in folder.iterdir() if one.is_symlink()}
        rows = [line.split() for line in Path("/proc/net/udp").read_text().splitlines()[1:]]
        addresses = {row[1].split(":")[0] for row in rows if f"socket:[{row[9]}]" in links}
    assert addresses == {"0100007F"}


def test_pictures_in_shared_memory_are_open_to_this_user_only_and_gone_with_their_owner(monkeypatch):
    def held(node):
        maps = Path(f"/proc/{node.pid}/maps").read_text()
        return {Path(path) for path in re.findall(r"/dev/shm/fastrtps_\S+", maps)}

    with ours("shared") as node:
        files = held(node)
        modes = {path.stat().st_mode & 0o777 for path in files}
    assert files
    assert modes == {0o600}
    assert all(path.exists() for path in files)  # it was killed
    monkeypatch.setattr(shared_memory, "_YOUNG", 0.0)
    shared_memory.clean()
    assert not any(path.exists() for path in files)
