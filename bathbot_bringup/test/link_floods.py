"""The 100 Hz stream while the controller's link is flooded: `python link_floods.py FLOOD SECONDS`.

FLOOD is none, datagrams (50 000 states a second from a stranger's port), garbage (lines that are no frames
between those of the controller, 100 MB a minute) or both. The arm goes to and fro between home and a target.
Prints what was sent, the gaps of more than 20 ms between two commands of a moving arm, as they came to the
emulated controller, and by how much the driver's memory grew.
"""

import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
from bathbot_bringup.sim.arm.trace import load_trace
from emulator_probe import Probe, driver_node, start
from std_srvs.srv import Trigger
from stop_latency import FAR_WALL, READY_DEG

from bathbot_msgs.msg import ArmState

MISSED, MOVING = 0.02, 1e-5  # [s], [rad] in one period
DATAGRAMS = """
import socket, sys, time
data, to = b'{"state": "realtime_arm_joint_state", "arm_err": 0}' * 20, ("127.0.0.1", int(sys.argv[1]))
sender, sent, begun = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), 0, time.monotonic()
while True:
    for _ in range(500):
        try:
            sender.sendto(data, to)
        except OSError:
            pass  # the port is bound anew
    sent += 500
    print(sent, flush=True)
    time.sleep(max(begun + sent / 50e3 - time.monotonic(), 0.0))
"""
PROXY = """
import random, socket, sys, threading, time
server, rate = socket.create_server(("127.0.0.1", 0)), float(sys.argv[2])
print(server.getsockname()[1], flush=True)
garbage = [random.randbytes(200).replace(b"\\n", b" ") + b"\\r\\n" for _ in range(500)]
sending, sent = threading.Lock(), 0
def forward(source, sink):
    while data := source.recv(65536):
        with sending:
            sink.sendall(data)
while True:
    driver, _ = server.accept()
    arm = socket.create_connection(("127.0.0.1", int(sys.argv[1])))
    for link in (arm, driver):
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    threading.Thread(target=forward, args=(driver, arm), daemon=True).start()
    threading.Thread(target=forward, args=(arm, driver), daemon=True).start()
    while rate:
        with sending:
            driver.sendall(b"".join(random.sample(garbage, 20)))
        sent += 20 * 202
        print(sent, flush=True)
        time.sleep(20 * 202 / rate)
"""


def resident(process):
    """Memory of a process [bytes]."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", status)[1]) << 10


def state_port(process):
    """The driver's UDP port for states: the one that is connected to the controller."""
    links = {os.readlink(link) for link in Path(f"/proc/{process.pid}/fd").iterdir() if link.is_symlink()}
    for row in Path("/proc/net/udp").read_text().splitlines()[1:]:
        part = row.split()
        if f"socket:[{part[9]}]" in links and not part[2].endswith(":0000"):
            return int(part[1].rpartition(":")[2], 16)
    raise LookupError("the driver believes no sender yet")


def counted(process, last):
    """Keep the newest number that a process has printed."""
    for line in process.stdout:
        last.append(int(line))
        del last[:-1]


def to_and_fro(probe, seconds):
    """Move the arm for so long."""
    over, out = time.monotonic() + seconds, False
    while time.monotonic() < over:
        if out := not out:
            probe.send(probe.goal())
        else:
            probe.services["home"].call_async(Trigger.Request())
        pause = min(time.monotonic() + 4.0, over)
        probe.until(lambda pause=pause: time.monotonic() > pause)
        probe.call("stop")
        probe.until(lambda: probe.state()[0] == ArmState.HOLD)


def main(kind, seconds):
    """Measure and print."""
    file = Path(tempfile.mkdtemp()) / "trace.npz"
    probe = Probe()
    arm = start("-c", FAR_WALL, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    rate = 100e6 / 60.0 if kind in ("garbage", "both") else 0.0
    proxy = start("-c", PROXY, arm.stdout.readline().strip(), str(rate), stdout=subprocess.PIPE)
    usual = {"stale_after": 2.0, "wait_at_most": 10.0, "joint_speed": 0.05, "joint_acceleration": 1.0}
    driver = driver_node(port=int(proxy.stdout.readline()), home_deg=list(READY_DEG), **usual)
    processes, lines, datagrams = [driver, proxy, arm], [0], [0]
    threading.Thread(target=driver.stdout.read, daemon=True).start()
    threading.Thread(target=counted, args=(proxy, lines), daemon=True).start()
    try:
        probe.until(lambda: probe.state()[2])
        time.sleep(2.0)
        if kind in ("datagrams", "both"):
            flood = start("-c", DATAGRAMS, str(state_port(driver)), stdout=subprocess.PIPE)
            processes.append(flood)
            threading.Thread(target=counted, args=(flood, datagrams), daemon=True).start()
        to_and_fro(probe, 10.0)
        before, sent, begun = resident(driver), datagrams[0], time.monotonic()
        to_and_fro(probe, seconds)
        grown, took = resident(driver) - before, time.monotonic() - begun
        said = probe.state()
        print(file, file=arm.stdin, flush=True)
        arm.stdout.readline()
    finally:
        for process in processes:
            process.kill()
    trace = load_trace(file)
    steps, gaps = np.abs(np.diff(trace.frame_joints, axis=0)).max(axis=1), np.diff(trace.frame_stamp)
    held_up = gaps[1:][steps[:-1] > MOVING]
    p99, most = 1e3 * np.percentile(held_up, [99, 100])
    print(
        f"{kind}: {(datagrams[0] - sent) / took:.0f} datagrams a second, {lines[0] / 1e6:.0f} MB of garbage; "
        f"{(held_up > MISSED).sum()} of {len(held_up)} periods above 20 ms, p99 {p99:.1f}, longest {most:.1f}"
        f"; memory grew by {grown / 1e6:.1f} MB; at the end {said}"
    )
    probe.close()


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]))
