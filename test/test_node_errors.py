"""A node that cannot start says why in one line and ends with exit code 2; none leaves a traceback."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from bathbot_depthcorr.node.dds import reach
from test_settings import NODES

pytestmark = [pytest.mark.graph, pytest.mark.timeout(300)]  # the first waits for all processes

BAD_FILES = [
    ("skin_detector", "model:=nowhere.onnx"),
    ("depth_corrector", "calibration:=nowhere.npz"),
    ("target_localizer", "hand_eye:=nowhere.yaml"),
    ("rm65_driver", "force_limits:=nowhere.yaml"),
    ("sim_camera", "scenario:=nowhere.yaml"),
]
BAD_VALUES = [
    ("rm65_driver", "rate:=50.0", "rate must lie in 100..500 Hz, got 50.0; the default is 100.0"),
    ("rm65_driver", "rate:=50", "rate must lie in 100..500 Hz, got 50.0"),
    ("scrub_planner", "ahead:=0", "ahead must be 1 or more, got 0; the default is 3"),
    ("sim_camera", "scene:=kitchen", "scene must be one of bathroom, chessboard, aruco, got 'kitchen'"),
    ("skin_detector", "size:=100", "size must be 0 px or more, in steps of 32, got 100"),
    ("replayer", "rate:=fast", "rate must be a float, got 'fast'"),
]
UNKNOWN = [(node, "nonsense:=1") for node in NODES]


def run(node: str, parameter: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", NODES[node], "--ros-args", "-p", parameter]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


@pytest.fixture(scope="module")
def ended() -> dict[tuple[str, str], subprocess.CompletedProcess]:
    """How each node ended with each parameter; two run at once, for most of the time is their imports."""
    lines = [*UNKNOWN, *BAD_FILES, *((node, parameter) for node, parameter, _ in BAD_VALUES)]
    with ThreadPoolExecutor(2) as pool:
        return dict(zip(lines, pool.map(lambda line: run(*line), lines), strict=True))


def check(ended: subprocess.CompletedProcess, words: str) -> None:
    said = ended.stdout + ended.stderr
    assert ended.returncode == 2, said
    assert "Traceback" not in said
    assert "FATAL" not in said
    errors = [line for line in said.splitlines() if "[ERROR]" in line]
    assert len(errors) == 1
    assert words in errors[0]


@pytest.mark.parametrize("line", UNKNOWN, ids=[node for node, _ in UNKNOWN])
def test_unknown_parameter(ended, line):
    check(ended[line], "unknown parameter nonsense")


@pytest.mark.parametrize("line", BAD_FILES, ids=[node for node, _ in BAD_FILES])
def test_missing_file(ended, line):
    check(ended[line], "nowhere")


@pytest.mark.parametrize(("node", "parameter", "words"), BAD_VALUES)
def test_a_value_outside_its_range(ended, node, parameter, words):
    check(ended[node, parameter], words)


def test_an_enclave_that_is_missing_is_told_before_ros_looks_for_it(tmp_path):
    keys = {**os.environ, **reach.network_variables(tmp_path, "/nobody")}
    command = [sys.executable, "-m", NODES["recorder"]]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, env=keys)
    assert ended.returncode == 2
    (line,) = (ended.stdout + ended.stderr).splitlines()
    assert "the enclave '/nobody' of" in line
