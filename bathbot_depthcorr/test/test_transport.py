"""A process with a deadline shares no memory with others, listens on loopback only, and is still heard."""

import os
import subprocess
import sys

import pytest
from bathbot_depthcorr.node.dds import transport

pytestmark = pytest.mark.graph

NODE = """
import os, sys
from bathbot_depthcorr.node import stage_node
from bathbot_depthcorr.node.dds import transport
if sys.argv[1] == "udp":
    transport.keep_clear_of_shared_memory()
import rclpy
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("probe_" + sys.argv[1])
heard = []
node.create_subscription(String, "from_" + sys.argv[2], heard.append, 10)
voice = node.create_publisher(String, "from_" + sys.argv[1], 10)
while len(heard) < 3:
    voice.publish(String(data="here"))
    rclpy.spin_once(node, timeout_sec=0.05)
for _ in range(20):
    voice.publish(String(data="here"))
    rclpy.spin_once(node, timeout_sec=0.05)
shared = sum("/dev/shm/fast" in line for line in open("/proc/self/maps"))
files = ["/proc/self/fd/" + name for name in os.listdir("/proc/self/fd")]
own = {os.readlink(file) for file in files if os.path.exists(file) or os.path.islink(file)}
ports = [line.split() for line in open("/proc/self/net/udp")][1:]
addresses = {port[1].split(":")[0] for port in ports if f"socket:[{port[9]}]" in own}
print(shared, *sorted(addresses), flush=True)
os._exit(0)
"""
LOOPBACK = "0100007F"


def environment(**changes):
    kept = {k: v for k, v in os.environ.items() if k not in (transport.RANGE, transport.PROFILES)}
    return kept | {"ROS_DOMAIN_ID": "57"} | changes


@pytest.mark.timeout(60)
def test_udp_and_shared_memory_hear_each_other():
    nodes = [
        subprocess.Popen(
            [sys.executable, "-c", NODE, *names], stdout=subprocess.PIPE, text=True, env=environment()
        )
        for names in (("udp", "shared"), ("shared", "udp"))
    ]
    try:
        udp, shared = (node.communicate(timeout=50)[0].split() for node in nodes)
    finally:
        for node in nodes:
            node.kill()
    assert udp == ["0", LOOPBACK]
    assert int(shared[0]) > 0
