"""A parameter file holds exactly the settings of its node: same names, same defaults' types."""

import ast
import importlib
import math
from dataclasses import fields
from pathlib import Path

import pytest
import yaml
from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.node.parameters import declared

ROOT = Path(__file__).parents[1]
NODES = {
    "depth_corrector": "bathbot_depthcorr.live.depth_corrector_node",
    "skin_detector": "bathbot_perception.skin_detector_node",
    "target_localizer": "bathbot_localize.target_localizer_node",
    "scrub_planner": "bathbot_scrub.scrub_planner_node",
    "rm65_driver": "bathbot_scrub.rm65.ros.rm65_driver_node",
    "recorder": "bathbot_bringup.bag.recording.recorder_node",
    "replayer": "bathbot_bringup.bag.replaying.replayer_node",
    "sim_camera": "bathbot_bringup.sim.camera.sim_camera_node",
    "sim_rm65": "bathbot_bringup.sim.arm.sim_rm65_node",
}

UNITS = {"", "m", "s", "Hz", "rad", "deg", "px", "m/s", "m/s^2", "rad/s", "rad/s^2", "kg", "degC", "MB"}


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


SETTINGS = [(node, name) for node, module in NODES.items() for name in declared(settings_type(module))]


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
def test_the_comments_of_the_yaml_are_the_descriptions(node):
    package = NODES[node].split(".")[0]
    comments: dict[str, str] = {}
    words: list[str] = []
    for line in (ROOT / package / "config" / f"{node}.yaml").read_text(encoding="utf-8").splitlines():
        if line.startswith("    # "):
            words.append(line.removeprefix("    # "))
        elif line.startswith("    "):
            comments[line.split(":")[0].strip()] = " ".join(words)
            words = []
    assert comments == {
        name: f"{setting.description}; {setting.rule}" if setting.rule else setting.description
        for name, setting in declared(settings_type(NODES[node])).items()
    }


@pytest.mark.parametrize(("node", "name"), SETTINGS, ids=lambda word: word)
def test_a_setting_is_understood_by_who_reads_nothing_else(node, name):
    setting = declared(settings_type(NODES[node]))[name]
    assert setting.allows(setting.default)
    assert len(setting.about.split()) >= 5
    assert setting.about[0].isupper()
    assert not setting.about.startswith("Of ")
    assert "[" not in setting.about, "the unit has a field of its own"
    assert setting.unit in UNITS


@pytest.mark.parametrize(("node", "name"), SETTINGS, ids=lambda word: word)
def test_a_value_beside_the_range_is_refused_in_one_line(node, name):
    kind = settings_type(NODES[node])
    setting = declared(kind)[name]
    beside = [end for end in (setting.above, setting.below) if end is not None]
    beside += [end - 1 for end in (setting.low,) if math.isfinite(end)]
    beside += [end + 1 for end in (setting.high,) if math.isfinite(end)]
    beside += [math.nan] if isinstance(setting.default, float) and setting.rule else []
    beside += ["nonsense"] if setting.choices else []
    if isinstance(setting.default, tuple):  # all numbers of it beside, or one too few
        beside = [(end,) * setting.length for end in beside]
        beside += [setting.default[1:]] if setting.length else []
    assert bool(beside) == bool(setting.rule)
    for value in beside:
        with pytest.raises(BathbotError) as caught:
            kind(**{name: value})
        assert str(caught.value).startswith(f"{name} {setting.rule}, got {value!r}; ")
        assert "\n" not in str(caught.value)
