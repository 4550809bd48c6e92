"""Stop request -> brake at the emulated controller, under a flood: `python stop_latency.py FLOOD COUNT`.

FLOOD is none, log (refused segments, 500 a second, into a pipe that nobody reads), huge (segments of 200 000
poses), cloud (clouds of a million points) or listener (a stopped one on all topics). The arm goes to and fro
between home and a target, and is stopped on the way. Prints percentiles in ms of the time from the request to
the first command that brakes, and to the last that moves, at the controller.
"""

import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
from emulator_cell import READY_DEG
from emulator_probe import Probe, driver_node, start
from std_srvs.srv import Trigger

from bathbot_msgs.msg import ArmState

FAR_WALL = """
from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings
from emulator_cell import READY_DEG, Wall
with Emulator(EmulatorSettings(port=0, joints_deg=READY_DEG), Wall(shift=-0.5)) as emulator:
    print(emulator.port, flush=True)
    emulator.trace.write(input())
    print("written", flush=True)
    input()
"""
FLOODS = """
import sys, time
import numpy as np
from bathbot_depthcorr.node import stage_node
import rclpy
from bathbot_localize.messages import cloud_from_surface
from bathbot_msgs.msg import ScrubSegment
from bathbot_scrub.segment.messages import message_from_segment
from emulator_cell import segments
from rclpy.qos import QoSProfile
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
rclpy.init()
node = rclpy.create_node("flood")
segment = message_from_segment(segments(1)[0])
if sys.argv[1] == "cloud":
    out, period = node.create_publisher(PointCloud2, "body_cloud", 1), 0.5
    segment = cloud_from_surface(np.full((1000, 1000, 3), -3.0), Header(frame_id="base_link"))
else:
    out, period = node.create_publisher(ScrubSegment, "scrub_segments", QoSProfile(depth=50)), 0.002
    segment.header.frame_id = "kitchen"
    if sys.argv[1] == "huge":
        segment.poses, period = [segment.poses[0]] * 200_000, 1.0
print("begins", flush=True)
while True:
    out.publish(segment)
    time.sleep(period)
"""

_NOISE = 2e-5  # [rad] the wire rounds to 0.001 deg


def flood(kind):
    """The process that floods, already at it; None for none."""
    if kind == "none":
        return None
    from test_driver_floods import LISTENER

    code = ("-c", LISTENER) if kind == "listener" else ("-c", FLOODS, kind)
    process = start(*code, stdout=subprocess.PIPE)
    process.stdout.readline()
    time.sleep(2.0)
    if kind == "listener":
        process.send_signal(signal.SIGSTOP)
    return process


def stops(probe, count):
    """Stop the arm on its way so often; when that was asked, time.monotonic() [s]."""
    asked, rng = [], np.random.default_rng(1)
    joints = lambda: np.array(probe.newest["joint_states"].position)  # noqa: E731
    pause = lambda until: probe.until(lambda: time.monotonic() > until)  # noqa: E731
    while len(asked) < count:
        if len(asked) % 2:
            probe.services["home"].call_async(Trigger.Request())
        else:
            probe.approach.send_goal_async(probe.goal())
        before = joints()
        probe.until(lambda before=before: np.abs(joints() - before).max() > 1e-3)
        pause(time.monotonic() + rng.uniform(0.05, 0.2))
        asked.append(time.monotonic())
        probe.call("stop")
        probe.until(lambda: probe.state()[0] == ArmState.HOLD)
        pause(time.monotonic() + 0.25)
    return asked


def latencies(stamps, joints, asked):
    """Time from each request to the first braking and to the last moving command [s], shape (N, 2)."""
    steps = np.concatenate([[0.0], np.abs(np.diff(joints, axis=0)).max(axis=1)])
    found = []
    for request in asked:
        first = last = int(np.searchsorted(stamps, request))
        while last + 1 < len(steps) and steps[last + 1] > 1e-6:
            last += 1
        begin = last
        shrinks = np.diff(steps) < -_NOISE  # at k: command k + 1 goes less far than command k
        while begin > first and shrinks[begin - 1]:
            begin -= 1
        begin += not shrinks[begin - 1] and begin < last  # it was the last at full speed
        found.append((stamps[begin] - request, stamps[last] - request))
    return np.maximum(found, 0.0)


def main(kind, count):
    """Measure and print."""
    file = Path(tempfile.mkdtemp()) / "trace.npz"
    probe = Probe()
    arm = start("-c", FAR_WALL, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    usual = {"stale_after": 2.0, "wait_at_most": 10.0, "joint_speed": 0.1, "joint_acceleration": 1.0}
    driver = driver_node(port=int(arm.stdout.readline()), home_deg=list(READY_DEG), **usual)
    if kind != "log":
        threading.Thread(target=driver.stdout.read, daemon=True).start()
    probe.until(lambda: probe.state()[2])
    flooding = flood(kind)
    try:
        asked = stops(probe, count)
        print(file, file=arm.stdin, flush=True)
        arm.stdout.readline()
    finally:
        for process in (flooding, driver, arm):
            if process is not None:
                process.kill()
    trace = np.load(file)
    braking, moving = 1e3 * latencies(trace["frame_stamp"], trace["frame_joints"], asked).T
    for what, values in (("first braking command", braking), ("last moving command", moving)):
        p50, p99, most = np.percentile(values, [50, 99, 100])
        print(f"{kind}: {what} after {p50:.1f} ms (median), {p99:.1f} (p99), {most:.1f} (max), {count} stops")
    probe.close()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
