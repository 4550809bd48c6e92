"""The demo ended by signals at random moments: `python signal_demo.py COUNT`.

Says of each what was wrong: its exit code, a process that it left, an arm that moved 250 ms after the signal
otherwise than off the skin, a bag that does not open, a summary that is missing, a traceback.
"""

import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import psutil
from bathbot_bringup.bag.reading import read_messages
from bathbot_bringup.errors import BagError

from bathbot_msgs.msg import ArmState

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
LONGEST, GRACE = 70.0, 0.25  # [s] of a demo before it is ended; for the arm to stand
MOVING = 0.01  # [rad/s] of a joint


def fastest_joint(bag, since):
    """The highest speed of a joint after that time [s], while the arm was not leaving the skin [rad/s]."""
    states = [(entry.time * 1e-9, entry.message.state) for entry in read_messages(bag, ("arm_state",))]
    joints = [(entry.time * 1e-9, entry.message.position) for entry in read_messages(bag, ("joint_states",))]
    joints = [(stamp, position) for stamp, position in joints if stamp > since]
    speeds = [0.0]
    for (stamp, before), (later, after) in zip(joints, joints[5:], strict=False):
        known = [state for told, state in states if told <= later]
        if not known or known[-1] != ArmState.RETRACTING:
            speeds.append(float(np.abs(np.subtract(after, before)).max() / (later - stamp)))
    return max(speeds)


def end_one(out, seed, delay, number):
    """Start a demo, end it, look at what is left; says what is wrong."""
    command = ("-m", "bathbot_bringup.command.cli", "demo", "--seed", str(seed), "--out", str(out))
    demo = subprocess.Popen(
        [sys.executable, *command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    with suppress(subprocess.TimeoutExpired):
        demo.wait(delay)
    ended, at, wrong = demo.poll() is not None, time.time(), []
    children = [] if ended else psutil.Process(demo.pid).children(recursive=True)
    demo.send_signal(number)
    said, _ = demo.communicate(timeout=120.0)
    took = time.time() - at
    if not ended and demo.returncode != 128 + number:
        wrong.append(f"code {demo.returncode}")
    if left := [child for child in children if child.is_running()]:
        wrong.append(f"{len(left)} processes left")
    if "Traceback" in said:
        wrong.append("traceback")
    if (out / "run.mcap").exists():
        try:
            if (speed := fastest_joint(out / "run.mcap", at + GRACE)) > MOVING:
                wrong.append(f"moved with {speed:.2f} rad/s")
            json.loads((out / "summary.json").read_text())
        except (BagError, OSError) as error:
            wrong.append(str(error))
    how = "had ended" if ended else f"{took:.1f} s to end"
    print(f"{number.name} after {delay:4.1f} s, {how}: {', '.join(wrong) or 'well'}", flush=True)
    return wrong


def main(count):
    """End so many demos."""
    rng, folder = random.Random(11), Path(tempfile.mkdtemp())
    found = [
        end_one(folder / str(seed), seed % 20, rng.uniform(0.3, LONGEST), rng.choice(SIGNALS))
        for seed in range(count)
    ]
    print(f"{sum(map(bool, found))} of {count} went wrong")


if __name__ == "__main__":
    main(int(sys.argv[1]))
