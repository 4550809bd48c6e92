"""The calibration coach: its screen, a silent camera, and a whole live calibration over DDS."""

import io
import os
import signal
import subprocess
import sys
import threading
from types import SimpleNamespace

import pytest
from bathbot_bringup.calibration.coach import CoachLoop, CoachScreen, CoachState, pose_words, render
from bathbot_bringup.calibration.coach_node import coach
from bathbot_bringup.calibration.depth_job import Job
from bathbot_bringup.errors import InputError
from bathbot_bringup.graph.isolation import free_domain, used_ports
from bathbot_bringup.graph.processes import isolated_environment
from bathbot_depthcorr.calibration.coverage import ViewPose
from bathbot_depthcorr.calibration_file import load
from bathbot_depthcorr.views.chessboard import Chessboard
from rich.console import Console

CAMERA = {
    "scene": "chessboard", "width": 640, "height": 360, "rate": 10.0, "hold": 0.8, "poses": 20,
    "autostart": True,
}  # fmt: skip


def shown(state, width=100):
    console = Console(file=io.StringIO(), width=width)
    console.print(render(state))
    return console.file.getvalue()


def test_the_screen_shows_what_is_missing_and_what_to_do():
    pose = ViewPose(0.8, 0.3, -0.2)
    empty, one = shown(CoachState()), shown(CoachState((pose,), pose, "view 1"))
    assert "0 views, 0% of the goals" in empty
    assert "now: no board in view" in empty
    assert "next: show the board from" in empty
    assert "■" not in empty
    assert "1 views" in one
    assert one.count("■") == 1 + 2 + 4  # distance, left and down, corners
    assert "now: 0.80 m, 17 deg left, 11 deg down" in one


def test_a_pose_in_words():
    assert pose_words(None) == "no board in view"
    assert pose_words(ViewPose(1.0, -0.1, 0.1)) == "1.00 m, 6 deg right, 6 deg up"


@pytest.mark.parametrize("terminal", [False, True])
def test_a_log_file_gets_one_line_per_event(terminal):
    console = Console(file=io.StringIO(), force_terminal=terminal, width=120)
    with CoachScreen(console) as screen:
        for event in ("looking", "looking", "view 1: left"):
            screen.show(CoachState((), None, event))
    said = console.file.getvalue()
    if not terminal:
        assert [line.split(" (")[0] for line in said.splitlines()] == ["looking", "view 1: left"]
    assert "view 1: left" in said


class Screen:
    """Keeps the last state."""

    def show(self, state):
        self.state = state


@pytest.mark.parametrize("count", [3, 10])
def test_enter_calibrates_with_enough_views(monkeypatch, count):
    poses = [ViewPose(0.5 + 0.05 * number, 0.2, 0.0) for number in range(count)]
    views, screen = SimpleNamespace(poses=poses, still_moment=lambda: None, glance=lambda: poses[0]), Screen()
    keyboard, line = os.openpty()
    with os.fdopen(line) as stdin, os.fdopen(keyboard, "w") as keys:
        monkeypatch.setattr(sys, "stdin", stdin)
        loop = CoachLoop(views, screen)
        assert not loop.done()
        keys.write("\n")
        keys.flush()
        loop.work()
    assert loop.done() == (count == 10)
    assert screen.state.present == poses[0]
    assert ("3 views are too few, 10 are needed" in screen.state.event) == (count == 3)


@pytest.mark.parametrize(("live", "source"), [(True, "bag"), (False, None)])
def test_a_bag_or_a_camera_is_given(tmp_path, live, source):
    with pytest.raises(InputError, match="either a bag, or --live"):
        Job(source, live, "camera", Chessboard(), "identity", tmp_path / "x.npz", None, None)


@pytest.mark.graph
def test_a_silent_camera_is_named(monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", str(free_domain(os.getpid(), used_ports())))
    with pytest.raises(InputError, match=r"nothing on /nobody/color/camera_info, .* within 0 s; is"):
        coach(Chessboard(), "nobody", patience=0.3)


@pytest.fixture
def environment(tmp_path):
    return isolated_environment(free_domain(os.getpid(), used_ports()), tmp_path / "logs")


@pytest.fixture
def camera(environment):
    """The simulated camera before the board, as a process."""
    values = [part for key, value in CAMERA.items() for part in ("-p", f"{key}:={value}")]
    process = subprocess.Popen(
        [sys.executable, "-m", "bathbot_bringup.sim.camera.sim_camera_node", "--ros-args", *values],
        env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    yield process
    process.send_signal(signal.SIGINT)
    process.wait(20.0)


@pytest.mark.graph
def test_a_camera_is_calibrated_live(camera, environment, tmp_path):
    """Poses are taken as they come; Ctrl-C with enough of them calibrates as from a bag."""
    options = ["--out", "unit.npz", "--views", "views", "--json", "report.json"]
    process = subprocess.Popen(
        [sys.executable, "-m", "bathbot_bringup.command.cli", "calibrate", "depth", "--live", *options],
        env=environment, cwd=tmp_path, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    watchdog = threading.Timer(80.0, process.kill)
    watchdog.start()
    taken = 0
    for line in process.stdout:
        taken += line.startswith("view ")
        if taken == 10:
            process.send_signal(signal.SIGINT)
            break
    said, complaint = process.communicate()
    watchdog.cancel()
    assert process.returncode == 0, complaint
    assert "Traceback" not in complaint
    assert "errors on 2 held out" in said
    assert load(tmp_path / "unit.npz").serial == "SIM455-0001-paper"
    assert sorted(file.name for file in tmp_path.iterdir()) == [
        "logs", "report.json", "unit.npz", "unit.png", "views",
    ]  # fmt: skip
    assert len(list((tmp_path / "views").glob("*.npz"))) == 10
