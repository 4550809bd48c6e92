"""The whole job, as a user starts it: real processes over DDS, from the first picture to the report."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from rosbags.highlevel import AnyReader

pytestmark = pytest.mark.graph

DEMO = [sys.executable, "-m", "bathbot_bringup.command.cli", "demo"]


def processes_with(text: str) -> list[str]:
    """Command lines of this machine that hold a text."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            line = entry.read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue
        if text in line:
            found.append(line)
    return found


@pytest.fixture(scope="module")
def bathed(tmp_path_factory):
    """One run of the demo and its summary."""
    out = tmp_path_factory.mktemp("demo") / "results"
    outcome = subprocess.run(
        [*DEMO, "--seed", "3", "--out", str(out)], capture_output=True, text=True, timeout=280
    )
    said = outcome.stdout + outcome.stderr
    assert outcome.returncode == 0, said
    return out, json.loads((out / "summary.json").read_text(encoding="utf-8"))


@pytest.mark.timeout(300)
class TestDemo:
    def test_the_job_is_done(self, bathed):
        _, summary = bathed
        assert (summary["done"], summary["failure"]) == (True, "")
        assert (summary["seed"], summary["region"], summary["simulated"]) == (3, "Trunk_skin", True)

    def test_the_target_is_where_it_was_found(self, bathed):
        assert bathed[1]["localization_error_mm"] < 8.0

    def test_the_path_is_scrubbed_in_contact(self, bathed):
        assert bathed[1]["contact_fraction"] >= 0.85
        assert bathed[1]["coverage"] > 0.5

    def test_the_arm_keeps_to_its_path(self, bathed):
        assert bathed[1]["path_y_error_max_mm"] < 2.23

    def test_the_force_stays_below_the_threshold(self, bathed):
        assert 0.5 < bathed[1]["force_peak_n"] < bathed[1]["force_threshold_n"]

    def test_the_commands_came_at_a_known_period(self, bathed):
        assert bathed[1]["command_period_p99_dev_ms"] is not None

    def test_everything_promised_is_there(self, bathed):
        out, _ = bathed
        names = {file.name for file in out.iterdir()}
        assert names == {"run.mcap", "metadata.yaml", "summary.json", "report.html", "logs"}
        assert (out / "report.html").read_text(encoding="utf-8").count("data:image/png") == 4

    def test_the_bag_is_a_rosbag_without_pictures(self, bathed):
        out, _ = bathed
        with AnyReader([out / "run.mcap"]) as reader:
            kinds = {connection.topic: connection.msgtype for connection in reader.connections}
        assert {
            "/arm_state",
            "/scrub_segments",
            "/contact_targets",
            "/sim_contact",
            "/tf_static",
        } <= kinds.keys()
        assert not {"sensor_msgs/msg/Image", "sensor_msgs/msg/PointCloud2"} & set(kinds.values())

    def test_only_this_user_may_look_into_what_it_leaves(self, bathed):
        left = [bathed[0], *(path for path in bathed[0].rglob("*") if not path.is_symlink())]
        assert len(left) > 10
        assert [path for path in left if path.stat().st_mode & 0o077] == []

    def test_no_process_is_left(self, bathed):
        assert processes_with(str(bathed[0])) == []


@pytest.mark.timeout(180)
@pytest.mark.parametrize(
    ("number", "said"),
    [(signal.SIGINT, "interrupted by Ctrl-C"), (signal.SIGHUP, "the terminal was closed")],
    ids=["ctrl-c", "hang-up"],
)
def test_a_signal_ends_all_and_is_named(tmp_path, number, said):
    ignored = signal.signal(signal.SIGHUP, signal.SIG_DFL)  # as in a terminal: programs inherit it
    with subprocess.Popen(
        [*DEMO, "--out", str(tmp_path / "out")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as demo:
        _wait_for(lambda: len(processes_with(str(tmp_path))) > 1, 60.0)
        time.sleep(1.0)
        signal.signal(signal.SIGHUP, ignored)
        demo.send_signal(number)
        out, err = demo.communicate(timeout=90.0)
    assert (demo.returncode, err) == (128 + number, "")
    assert said in out
    assert processes_with(str(tmp_path)) == []
    assert json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))["done"] is False


@pytest.mark.timeout(180)
def test_a_node_that_dies_is_named(tmp_path):
    with subprocess.Popen(
        [*DEMO, "--out", str(tmp_path / "out")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as demo:
        _wait_for(lambda: (tmp_path / "out" / "logs" / "scrub_planner.log").exists(), 60.0)
        time.sleep(1.0)
        os.kill(_pid_of("bathbot_scrub.scrub_planner_node", demo.pid), signal.SIGKILL)
        out, _ = demo.communicate(timeout=120.0)
    assert demo.returncode == 1
    assert "node scrub_planner was ended by signal 9" in out
    assert processes_with(str(tmp_path)) == []


def _wait_for(condition, timeout: float) -> None:
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, f"not within {timeout} s"
        time.sleep(0.1)


def _pid_of(module: str, parent: int) -> int:
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = entry.read_text(encoding="utf-8").rpartition(")")[2].split()
            line = (entry.parent / "cmdline").read_bytes().decode(errors="replace")
        except OSError:
            continue
        if int(fields[1]) == parent and module in line:
            return int(entry.parent.name)
    raise AssertionError(f"{module} does not run")
