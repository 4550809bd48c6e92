"""The vendor's own client judges the emulator: no call may end in an error code."""

import contextlib
import importlib.util
import json
import platform
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from bathbot_bringup.sim.arm.emulator.emulator import Emulator
from bathbot_bringup.sim.arm.emulator.settings import EmulatorSettings

pytestmark = pytest.mark.graph

SESSION = Path(__file__).with_name("vendor_session.py")

if importlib.util.find_spec("Robotic_Arm") is None:
    pytest.skip("the vendor's client (Robotic-Arm) is not installed here", allow_module_level=True)
if (sys.platform, platform.machine()) not in (("linux", "x86_64"), ("linux", "aarch64")):
    pytest.skip("the vendor's client is made for Linux on x86-64 and arm64 only", allow_module_level=True)


def free_udp_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


@pytest.fixture(scope="module")
def sessions():
    """What was printed in a session with each generation; both run at once, to save time."""
    running = {}
    with contextlib.ExitStack() as stack:
        for generation in (3, 4):
            port = free_udp_port()
            settings = EmulatorSettings(port=0, udp_port=port, generation=generation)
            emulator = stack.enter_context(Emulator(settings))
            command = [sys.executable, SESSION, *map(str, (emulator.port, port, generation))]
            process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
            stack.callback(process.kill)
            running[generation] = (emulator, process)
        outputs = {key: process.communicate(timeout=120)[0] for key, (_, process) in running.items()}
        yield {key: (outputs[key], *running[key]) for key in running}


@pytest.mark.parametrize("generation", [3, 4])
def test_the_vendor_s_client_finds_no_fault(sessions, generation):
    output, emulator, process = sessions[generation]
    lines = [json.loads(line) for line in output.splitlines() if line.startswith("{")]
    assert process.returncode == 0, output[-500:]
    assert not [line for line in lines if line["call"] != "push" and line["code"] != 0]
    push = next(line for line in lines if line["call"] == "push")
    assert push["code"] == [0]
    # idle, move_L, move_J, move_C, move_S; through joint, stop, slow stop, pause
    assert ({0, 1, 2, 3, 4} if generation == 3 else {0, 1, 2, 5, 9, 10, 11}) <= set(push["states"])
    assert push["count"] > 200
    assert lines[-1] == {"call": "delete", "code": 0}
    assert emulator.refused == 0
