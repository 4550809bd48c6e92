"""The demo ended by signals at random moments: `python signal_demo.py COUNT [kills]`.

With `kills` one of its nodes is killed, or the demo itself, with no chance to say anything. Says of each what
was wrong: its exit code, a cause that it did not name, a process that it left, an arm that moved 250 ms after
the signal otherwise than off the skin, a bag that does not open, a summary that is missing, a traceback.
"""

import json
import random
import re
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
ORPHANS = 15.0  # [s] for the nodes of a demo that was killed to end
NODE = re.compile(r"\.(\w+)_node ")
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


def end_one(out, seed, delay, number, kill=None):
    """Start a demo, end it, look at what is left; says what is wrong.

    With `kill` one of its processes is killed: which, of all, is that share of their number.
    """
    command = ("-m", "bathbot_bringup.command.cli", "demo", "--seed", str(seed), "--out", str(out))
    demo = subprocess.Popen(
        [sys.executable, *command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    with suppress(subprocess.TimeoutExpired):
        demo.wait(delay)
    ended, at, wrong = demo.poll() is not None, time.time(), []
    children = [] if ended else psutil.Process(demo.pid).children(recursive=True)
    victim = demo if kill is None or ended else [demo, *children][int(kill * (len(children) + 1))]
    name = "demo" if victim is demo else NODE.search(" ".join(victim.cmdline()))[1]
    victim.send_signal(number)
    said, _ = demo.communicate(timeout=120.0)
    took = time.time() - at
    code = -number if victim is demo and number == signal.SIGKILL else 1 if kill is not None else 128 + number
    if not ended and demo.returncode != code:
        wrong.append(f"code {demo.returncode}")
    if victim is not demo and f"node {name} was ended by signal 9" not in said.replace("\n", " "):
        wrong.append("not named")
    if victim is demo and number == signal.SIGKILL:
        psutil.wait_procs(children, ORPHANS)
    if left := [child for child in children if child.is_running()]:
        wrong.append(f"{len(left)} processes left")
    if "Traceback" in said:
        wrong.append("traceback")
    if (out / "run.mcap").exists():
        try:
            if (speed := fastest_joint(out / "run.mcap", at + GRACE)) > MOVING:
                wrong.append(f"moved with {speed:.2f} rad/s")
            if code > 0:
                json.loads((out / "summary.json").read_text())
        except (BagError, OSError) as error:
            wrong.append(str(error))
    how = "had ended" if ended else f"{took:.1f} s to end"
    print(f"{number.name} to {name} after {delay:4.1f} s, {how}: {', '.join(wrong) or 'well'}", flush=True)
    return wrong


def main(count, kills):
    """End so many demos."""
    rng, folder, found = random.Random(11), Path(tempfile.mkdtemp()), []
    for seed in range(count):
        out, delay, number = folder / str(seed), rng.uniform(0.3, LONGEST), rng.choice(SIGNALS)
        how = (signal.SIGKILL, rng.random()) if kills else (number,)
        found.append(end_one(out, seed % 20, delay, *how))
    print(f"{sum(map(bool, found))} of {count} went wrong")


if __name__ == "__main__":
    main(int(sys.argv[1]), "kills" in sys.argv)
