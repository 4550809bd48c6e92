"""A node that cannot start says why in one line and ends with exit code 2; none leaves a traceback."""

import subprocess
import sys

import pytest
from test_settings import NODES

pytestmark = pytest.mark.graph

BAD_FILES = [
    ("skin_detector", "model:=nowhere.onnx"),
    ("depth_corrector", "calibration:=nowhere.npz"),
    ("target_localizer", "hand_eye:=nowhere.yaml"),
    ("rm65_driver", "force_limits:=nowhere.yaml"),
    ("sim_camera", "scenario:=nowhere.yaml"),
]


def run(node: str, parameter: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", NODES[node], "--ros-args", "-p", parameter]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def check(ended: subprocess.CompletedProcess, words: str) -> None:
    said = ended.stdout + ended.stderr
    assert ended.returncode == 2, said
    assert "Traceback" not in said
    assert "FATAL" not in said
    errors = [line for line in said.splitlines() if "[ERROR]" in line]
    assert len(errors) == 1
    assert words in errors[0]


@pytest.mark.parametrize("node", NODES)
def test_unknown_parameter(node):
    check(run(node, "nonsense:=1"), "unknown parameter nonsense")


@pytest.mark.parametrize(("node", "parameter"), BAD_FILES, ids=[node for node, _ in BAD_FILES])
def test_missing_file(node, parameter):
    check(run(node, parameter), "nowhere")
