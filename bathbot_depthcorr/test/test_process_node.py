"""A process that is one node ends in order, and then at once."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.graph

PROGRAM = """
import ctypes
from dataclasses import dataclass

from bathbot_depthcorr.node.parameters import setting
from bathbot_depthcorr.node.process_node import run
from bathbot_depthcorr.node.stage_node import StageNode


@dataclass(frozen=True)
class Settings:
    loud: bool = setting(True, "Whether it speaks")
    crashes: bool = setting(False, "Whether it crashes as soon as it runs")

class Guest(StageNode):
    def __init__(self):
        super().__init__("guest", Settings)

    def start(self):
        print("begun", flush=True)
        if self.get_parameter("crashes").value:
            self.every(0.1, ctypes.PyDLL(None).abort)  # no other thread runs any more

    def stop(self):
        print("left in order")


# stands for the destructors of a library, which may find its threads still at work
crash = ctypes.CFUNCTYPE(None)(lambda: ctypes.CDLL(None).abort())
ctypes.CDLL(None).__cxa_atexit(crash, None, None)
run(Guest)
"""


def guest(*arguments):
    environment = os.environ | {"ROS_DOMAIN_ID": str(1 + os.getpid() % 100), "PYTHONUNBUFFERED": ""}
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *arguments],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_a_node_that_is_asked_to_end_leaves_in_order_and_no_destructor_runs_behind_it():
    process = guest()
    assert process.stdout.readline() == "begun\n"
    process.send_signal(signal.SIGINT)
    told, _ = process.communicate(timeout=30.0)
    assert told == "left in order\n"
    assert process.returncode == 0


def shared_memory(process):
    """Files of shared memory that a process holds."""
    maps = Path(f"/proc/{process.pid}/maps").read_text()
    return {Path(name) for name in re.findall(r"/dev/shm/fastrtps_[0-9a-f]+", maps)}


def test_a_node_that_has_ended_leaves_nothing_in_shared_memory():
    process = guest()
    assert process.stdout.readline() == "begun\n"
    held = shared_memory(process)
    assert held
    assert all(path.exists() for path in held)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=30.0)
    assert not [path for path in held if path.exists()]


def test_a_node_that_cannot_start_says_why_and_ends_with_2():
    process = guest("--ros-args", "-p", "loud:=tea")
    _, complaint = process.communicate(timeout=30.0)
    assert "loud" in complaint
    assert process.returncode == 2


def test_a_node_that_crashes_says_where():
    process = guest("--ros-args", "-p", "crashes:=true")
    _, complaint = process.communicate(timeout=30.0)
    assert "Fatal Python error: Aborted" in complaint
    assert process.returncode == -signal.SIGABRT
