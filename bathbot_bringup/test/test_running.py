"""A graph of our own: active inside, watched, and gone at the end."""

import subprocess
import sys

import pytest
from bathbot_bringup.errors import InputError, ProcessError
from bathbot_bringup.graph.running import running, started

pytestmark = pytest.mark.graph


def test_nodes_are_active_inside_watched_and_gone_afterwards(tmp_path):
    bag = {"bag": tmp_path / "bag"}
    with running({"recorder": bag}, tmp_path / "logs", "bathbot_test") as graph:
        (recorder,) = graph.group.children
        assert graph.client.is_active("recorder")
        recorder.process.kill()
        with pytest.raises(ProcessError, match="recorder was ended by signal 9"):
            graph.client.wait(20.0)
    with running({}, tmp_path / "logs", "bathbot_test") as other:
        assert other.domain != graph.domain
        later = other.start("recorder", {"bag": tmp_path / "again"})  # the killed one has left its own
        other.wait_until_active()
    assert later.process.poll() is not None
    assert (tmp_path / "logs" / "recorder.log").is_file()


def test_a_node_that_refuses_its_input_is_named_and_nothing_stays(tmp_path):
    with started(
        {"recorder": {"bag": tmp_path, "profile": "tea"}}, tmp_path / "logs", "bathbot_test"
    ) as graph:
        (recorder,) = graph.group.children
        with pytest.raises(ProcessError, match="no privacy profile is named 'tea'") as refused:
            graph.wait_until_active()
    assert refused.value.exit_code == 2
    assert recorder.process.poll() == 2


def test_an_unknown_node_is_refused_before_anything_runs(tmp_path):
    with pytest.raises(InputError, match="did you mean recorder"), started({"recorde": {}}, tmp_path, "x"):
        pytest.fail("it was started")


@pytest.mark.parametrize("module", ["graph.running", "evaluation.safety.run", "evaluation.demo"])
def test_ros_is_loaded_only_with_a_graph(module):
    program = f"import sys, bathbot_bringup.{module}; print(*sys.modules)"
    outcome = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "rclpy" not in outcome.stdout.split()
