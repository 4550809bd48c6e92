"""Complaints of ROS in words for a person, one line each."""

import subprocess
import sys

import pytest
from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.node.dds import ros_words
from hypothesis import given
from hypothesis import strategies as st

GUEST = """
from bathbot_depthcorr.live.depth_corrector_node import main
main()
"""


@given(number=st.integers(-1000, 1000))
def test_a_domain_is_one_that_dds_has_ports_for(number):
    environment = {"ROS_DOMAIN_ID": str(number)}
    if 0 <= number <= 232:
        assert ros_words.domain(environment) == number
    else:
        with pytest.raises(SettingsError, match="0 to 232"):
            ros_words.domain(environment)


@pytest.mark.parametrize("said", ["abc", "1.5", "0x10", " 7"])
def test_what_is_no_number_is_no_domain(said):
    with pytest.raises(SettingsError, match="must be a whole number"):
        ros_words.domain({"ROS_DOMAIN_ID": said})


def test_none_is_asked_for_where_nothing_is_said():
    assert ros_words.domain({}) is None
    assert ros_words.domain({"ROS_DOMAIN_ID": ""}) is None


def test_what_nobody_foresaw_is_told_without_the_places_in_the_source():
    said = ros_words.told(RuntimeError("failed to initialize rcl: no memory, at /project/src/rcl/init.c:12"))
    assert said == "ROS cannot begin: failed to initialize rcl: no memory; see what is set: env | grep ROS"


@pytest.mark.graph
@pytest.mark.parametrize(("arguments", "said"), [
    (["-p", "calibration"], "'-p calibration' after --ros-args cannot be read; write -p name:=value"),
    (["-r"], "lacks its value"),
    (["-r", "a b:=c d"], "'-r a b:=c d' after --ros-args cannot be read; write -r from:=to"),
    (["--params-file", "/nowhere.yaml"], "'--params-file /nowhere.yaml'"),
    (["--log-level", "loud"], "write --log-level debug, info"),
    (["--loud"], "unknown arguments after --ros-args: ['--loud']"),
    ({"ROS_DOMAIN_ID": "300"}, "ROS_DOMAIN_ID is '300'"),
    ({"ROS_LOG_DIR": "/proc/nowhere"}, "logs cannot be written below /proc/nowhere"),
])  # fmt: skip
def test_each_complaint_is_one_line_and_exit_code_2(monkeypatch, arguments, said):
    for name, value in arguments.items() if isinstance(arguments, dict) else ():
        monkeypatch.setenv(name, value)
    given_ = ["--ros-args", *arguments] if isinstance(arguments, list) else []
    node = subprocess.run([sys.executable, "-c", GUEST, *given_], capture_output=True, text=True, timeout=30)
    assert node.returncode == 2
    assert said in node.stderr
    assert len(node.stderr.splitlines()) == 1
