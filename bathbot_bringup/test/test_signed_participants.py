"""Two network namespaces, a cable between them, keys of `bathbot keys`: who hears what.

The Fast DDS of the wheels has no security and refuses to join; then the tests of the cable are skipped.
"""

import json
import os
import shutil
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager

import pytest
from bathbot_bringup.graph.keys import rights
from bathbot_bringup.graph.keys.keystore import make_keystore
from bathbot_depthcorr.node.dds import reach

pytestmark = pytest.mark.graph
DOMAIN = 59
ADDRESSES = ("10.213.59.1", "10.213.59.2")
_OPENS = 2.0  # [s] for a new cable; participants that began before did not find each other, one time in three
ROBOT, WATCHER = rights.robot(), rights.watcher(["*/wrench"])
BEGIN = """
import json, os, sys, time
import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
KINDS = {"/picture": Image, "/wrench": WrenchStamped}
def joined(name, namespace):
    if "BATHBOT_REACH" not in os.environ:  # plain ROS, as a stranger has it
        rclpy.init()
        return Node(name, namespace=namespace)
    from bathbot_depthcorr.errors import BathbotError
    from bathbot_depthcorr.node.dds import participant_node
    try:
        participant_node.begin()
        with participant_node.joining():
            return Node(name, namespace=namespace)
    except BathbotError as error:
        print(json.dumps(str(error)), flush=True)
        os._exit(2)
"""
SPEAKS = f"""{BEGIN}
node = joined("robot", "/")
voices = [(node.create_publisher(kind, name, 5), kind()) for name, kind in KINDS.items()]
service = node.create_service(Trigger, "/stop", lambda _, answer: answer)
print(json.dumps(""), flush=True)
while True:
    for voice, message in voices:
        voice.publish(message)
    rclpy.spin_once(node, timeout_sec=0.05)
"""
HEARS = f"""{BEGIN}
from rclpy.impl.implementation_singleton import rclpy_implementation
node, end = joined("other", "/watcher"), time.monotonic() + float(sys.argv[1])
said = dict.fromkeys([*KINDS, "/stop"], "nothing")
def made(name, make):
    try:
        return make()
    except rclpy_implementation.RCLError:
        said[name] = "refused"
def hear(name):
    return lambda _: said.update({{name: "heard"}})
for name, kind in KINDS.items():
    made(name, lambda: node.create_subscription(kind, name, hear(name), 5))
stop = made("/stop", lambda: node.create_client(Trigger, "/stop"))
asked = False
while time.monotonic() < end and "nothing" in said.values():
    if stop and not asked and stop.service_is_ready():
        stop.call_async(Trigger.Request()).add_done_callback(hear("/stop"))
        asked = True
    rclpy.spin_once(node, timeout_sec=0.05)
print(json.dumps(list(said.values())))
os._exit(0)
"""


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return make_keystore(tmp_path_factory.mktemp("keys") / "keystore", (ROBOT, WATCHER), [DOMAIN], 1).folder


def environment(said):
    foreign = ("ROS_SECURITY", "ROS_STATIC", "ROS_AUTOMATIC", "ROS_DISCOVERY", "FASTRTPS", reach.VARIABLE)
    inherited = {name: value for name, value in os.environ.items() if not name.startswith(foreign)}
    peers = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": ";".join(ADDRESSES)}
    peers["FASTDDS_BUILTIN_TRANSPORTS"] = "UDPv4"  # two machines share no memory, as two namespaces do
    return inherited | peers | {"ROS_DOMAIN_ID": str(DOMAIN), "AMENT_PREFIX_PATH": sys.prefix} | said


@contextmanager
def robot(said, *before):
    """What speaks; gives why it could not join, or nothing."""
    program = [*before, sys.executable, "-c", SPEAKS]
    process = subprocess.Popen(program, env=environment(said), stdout=subprocess.PIPE, text=True)
    try:
        yield json.loads(process.stdout.readline()), process
    finally:
        process.kill()
        process.wait()


def experience(said, *before, patience=20.0):
    """What somebody who listens hears, and what is refused."""
    program = [*before, sys.executable, "-c", HEARS, str(patience)]
    told = subprocess.run(
        program, env=environment(said), stdout=subprocess.PIPE, text=True, timeout=60, check=True
    )
    return json.loads(told.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def cable():
    """The beginnings of commands that run at its two ends, each a network namespace."""
    if os.geteuid() != 0 or not all(map(shutil.which, ("ip", "nsenter", "unshare"))):
        pytest.skip("only root can lay a cable between network namespaces, with iproute2 and util-linux")
    with ExitStack() as stack:
        homes = []
        for _ in ADDRESSES:
            inside = ["unshare", "--net", "sh", "-c", "ip link set lo up && echo && exec sleep 200"]
            homes.append(stack.enter_context(subprocess.Popen(inside, stdout=subprocess.PIPE)))
            stack.callback(homes[-1].kill)  # and with the namespaces the cable is gone
            homes[-1].stdout.readline()
        ends = [["nsenter", "--net", f"--target={home.pid}"] for home in homes]
        laying = ["ip", "link", "add", "eth0", "type", "veth", "peer", "eth0", "netns", str(homes[1].pid)]
        steps = [[*ends[0], *laying]]
        for end, address in zip(ends, ADDRESSES, strict=True):
            steps += [
                [*end, "ip", "address", "add", f"{address}/30", "dev", "eth0"],
                [*end, "ip", "link", "set", "eth0", "up"],
            ]
        for step in steps:
            if (done := subprocess.run(step, capture_output=True, text=True, check=False)).returncode:
                pytest.skip(f"this machine lays no cable between network namespaces: {done.stderr}")
        time.sleep(_OPENS)
        yield ends


@pytest.fixture(scope="module")
def signed_robot(store, cable):
    """What speaks at one end, with the robot's key."""
    with robot(reach.network_variables(store, ROBOT.name), *cable[0]) as (refusal, _):
        if "security libraries" in refusal:
            pytest.skip(refusal)
        assert refusal == ""
        yield


def test_who_forbids_nothing_is_heard_over_this_cable(cable):
    """Plain ROS at both ends: what is not heard below is not heard for want of a key."""
    with robot({}, *cable[0]):
        assert experience({}, *cable[1]) == ["heard", "heard", "heard"]


@pytest.mark.parametrize(("name", "said"), [
    pytest.param(ROBOT.name, ["heard", "heard", "heard"], id="robot"),
    pytest.param(WATCHER.name, ["refused", "heard", "refused"], id="watcher"),
    pytest.param(None, ["nothing", "nothing", "nothing"], id="no key"),
])  # fmt: skip
@pytest.mark.usefixtures("signed_robot")
def test_over_the_cable_each_hears_what_its_key_allows(name, said, store, cable):
    """Of the picture, the wrench and the answer of the service."""
    keys = reach.network_variables(store, name) if name else {}
    assert experience(keys, *cable[1], patience=20.0 if name else 5.0) == said


def test_what_dds_refuses_is_told_in_one_line_with_code_2(store):
    """A domain that the keys are not for, or a DDS without security."""
    with robot(reach.network_variables(store, ROBOT.name) | {"ROS_DOMAIN_ID": "60"}) as (refusal, process):
        assert refusal.startswith("no node can join with these keys: ")
        assert process.wait(10.0) == 2
