"""A parameter file holds exactly the settings of its node: same names, same defaults' types."""

import ast
import importlib
from dataclasses import fields
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
NODES = {
    "depth_corrector": "bathbot_depthcorr.live.depth_corrector_node",
    "skin_detector": "bathbot_perception.skin_detector_node",
    "target_localizer": "bathbot_localize.target_localizer_node",
    "scrub_planner": "bathbot_scrub.scrub_planner_node",
    "rm65_driver": "bathbot_scrub.rm65.ros.rm65_driver_node",
    "recorder": "bathbot_bringup.bag.recorder_node",
    "replayer": "bathbot_bringup.bag.replayer_node",
    "sim_camera": "bathbot_bringup.sim.camera.sim_camera_node",
    "sim_rm65": "bathbot_bringup.sim.arm.sim_rm65_node",
}


def settings_type(module_name: str) -> type:
    """The dataclass that a node hands to StageNode, read from its source: importing runs nothing."""
    module = importlib.import_module(module_name)
    for call in ast.walk(ast.parse(Path(module.__file__).read_text(encoding="utf-8"))):
        if (
            isinstance(call, ast.Call)
            and ast.unparse(call.func) == "super().__init__"
            and len(call.args) >= 2
        ):
            return getattr(module, ast.unparse(call.args[1]))
    raise AssertionError(f"{module_name} has no StageNode")


def parameters(node: str) -> dict:
    package = NODES[node].split(".")[0]
    document = yaml.safe_load((ROOT / package / "config" / f"{node}.yaml").read_text(encoding="utf-8"))
    assert list(document) == [f"/**/{node}"] or list(document) == [node]
    return next(iter(document.values()))["ros__parameters"]


@pytest.mark.parametrize("node", NODES)
def test_yaml_and_dataclass_have_the_same_keys(node):
    assert set(parameters(node)) == {field.name for field in fields(settings_type(NODES[node]))}


@pytest.mark.parametrize("node", NODES)
def test_the_yaml_is_accepted(node):
    values = {
        key: tuple(value) if isinstance(value, list) else value for key, value in parameters(node).items()
    }
    settings_type(NODES[node])(**values)


@pytest.mark.parametrize("node", NODES)
def test_every_setting_says_what_it_means(node):
    assert [
        field.name for field in fields(settings_type(NODES[node])) if not field.metadata.get("help")
    ] == []
