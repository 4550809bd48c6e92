"""`bathbot sim-arm` as a process: a clear first line, faults told, a clean end."""

import os
import signal
import socket
import subprocess
import sys

import pytest
from bathbot_bringup.command import cli
from bathbot_bringup.sim.arm.trace import load_trace
from bathbot_bringup.sim.faults.kinds import KINDS
from bathbot_scrub.rm65.controller.protocol import FrameBuffer, encode

pytestmark = pytest.mark.graph


def test_it_serves_tells_of_faults_and_ends_cleanly(tmp_path):
    scenario, trace = tmp_path / "faulty.yaml", tmp_path / "trace.npz"
    scenario.write_text("faults: [{kind: lost_udp, after: 0.1, duration: 0.1}]\n")
    process = subprocess.Popen(
        [sys.executable, "-m", "bathbot_bringup.command.cli", "sim-arm", "--port", "0", "--no-person",
         "--generation", "4", "--variant", "6FB", "--scenario", str(scenario), "--trace", str(trace)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    try:
        first = process.stdout.readline()
        assert first.startswith("RM65-6FB, generation 4: TCP 127.0.0.1:")
        port = int(first.split("127.0.0.1:")[1].split(",")[0])
        with socket.create_connection(("127.0.0.1", port), timeout=10.0) as client:
            client.sendall(encode({"command": "get_arm_software_info"}))
            (info,) = FrameBuffer().feed(client.recv(65536))
        assert (info["Product_version"], info["robot_controller_version"]) == ("RM65-6FBI", "4.0")
        assert process.stdout.readline() == "fault lost_udp begins\n"
        assert process.stdout.readline() == "fault lost_udp ends\n"
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=30.0)
    finally:
        process.kill()
    assert process.returncode == 130
    assert "Traceback" not in rest
    assert rest.startswith("ended: ")
    assert load_trace(trace).event_kind.tolist() == ["lost_udp", "lost_udp"]


def test_help_names_every_kind_of_fault(capsys):
    assert cli.run(["sim-arm", "--help"]) == 0
    told = capsys.readouterr().out
    assert all(f"  {kind} " in told for kind in KINDS)


@pytest.mark.parametrize(
    "option",
    [
        ("--generation", "2"),
        ("--variant", "7"),
        ("--host", ""),
        ("--scenario", "storm"),
        ("--port", "x"),
        ("--trace", "x.txt"),
    ],
)
def test_a_bad_option_ends_in_one_line(capsys, option):
    assert cli.run(["sim-arm", *option]) == 2
    assert os.sched_getscheduler(0) == os.SCHED_OTHER  # else all that is started later would press ahead
    told = capsys.readouterr().err
    assert told.startswith("bathbot: ")
    assert len(told.splitlines()) == 1
