"""Launch files, executed with stand-ins for launch and launch_ros, which plain Python lacks."""

import ast
import itertools
import runpy
import sys
from pathlib import Path
from types import ModuleType

import pytest
from bathbot_depthcorr.node.dds import reach, transport

ROOT = Path(__file__).parents[2]
FILES = sorted(ROOT.glob("bathbot_*/launch/*.launch.py"))
SHARED = ROOT / "bathbot_depthcorr/bathbot_depthcorr/one_node_launch.py"
FOREIGN = {"realsense2_camera"}


class Part:
    """Anything a launch file makes: remembers how it was called."""

    def __init__(self, *args, **kwargs):
        self.args, self.kwargs = args, kwargs

    def every(self, kind: str) -> list["Part"]:
        found = [self] if type(self).__name__ == kind else []
        for value in [*self.args, *self.kwargs.values()]:
            found += [part for entry in _flat(value) for part in entry.every(kind)]
        return found


def _flat(value) -> list[Part]:
    if isinstance(value, Part):
        return [value]
    if isinstance(value, dict):
        return [part for entry in value.values() for part in _flat(entry)]
    if isinstance(value, str | type):
        return []
    return [part for entry in value for part in _flat(entry)] if hasattr(value, "__iter__") else []


@pytest.fixture
def run(monkeypatch):
    """Run a launch file and give its description."""

    def execute(file: Path) -> Part:
        sources = [path.read_text(encoding="utf-8") for path in (file, SHARED)]
        for node in itertools.chain(*(ast.walk(ast.parse(source)) for source in sources)):
            if isinstance(node, ast.ImportFrom) and node.module.startswith("launch"):
                module = sys.modules.get(node.module) or ModuleType(node.module)
                for alias in node.names:
                    if not hasattr(module, alias.name):
                        setattr(module, alias.name, type(alias.name, (Part,), {}))
                monkeypatch.setitem(sys.modules, node.module, module)
        return runpy.run_path(str(file))["generate_launch_description"]()

    return execute


def share_of(part: Part) -> Path:
    """The folder that FindPackageShare would give, in this checkout."""
    return ROOT / part.args[0]


def joined(part: Part) -> Path:
    """The path that PathJoinSubstitution would give."""
    first, *rest = part.args[0]
    return share_of(first).joinpath(*rest)


def test_all_launch_files_are_there():
    assert {file.name for file in (ROOT / "bathbot_bringup/launch").iterdir()} >= {
        "sim.launch.py", "robot.launch.py", "replay.launch.py", "record.launch.py", "pipeline.launch.py",
    }  # fmt: skip


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_what_it_names_exists(file, run):
    description = run(file)
    nodes = description.every("LifecycleNode") + description.every("Node")
    assert nodes or description.every("IncludeLaunchDescription")
    for node in nodes:
        package, executable = node.kwargs["package"], node.kwargs["executable"]
        if package not in FOREIGN:
            assert f'"{executable} = {package}.' in (ROOT / package / "setup.py").read_text(encoding="utf-8")
    for path in description.every("PathJoinSubstitution"):
        assert joined(path).is_file(), joined(path)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_every_argument_it_uses_is_declared(file, run):
    description = run(file)
    declared = {part.args[0] for part in description.every("DeclareLaunchArgument")}
    used = {part.args[0] for part in description.every("LaunchConfiguration")}
    assert used <= declared


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_every_argument_is_explained(file, run):
    assert all(part.kwargs["description"] for part in run(file).every("DeclareLaunchArgument"))


def test_included_files_know_the_arguments_they_are_given(run):
    pipeline = run(ROOT / "bathbot_bringup/launch/pipeline.launch.py")
    known = {part.args[0] for part in pipeline.every("DeclareLaunchArgument")}
    for name in ("sim", "robot", "replay"):
        for include in run(ROOT / f"bathbot_bringup/launch/{name}.launch.py").every(
            "IncludeLaunchDescription"
        ):
            assert dict(include.kwargs["launch_arguments"]).keys() <= known


def test_the_drivers_of_others_keep_to_this_machine_too(run, monkeypatch):
    """What is set before a process is started holds for it; ROS's default shows pictures to the network."""
    monkeypatch.delenv(reach.VARIABLE, raising=False)
    description = run(ROOT / "bathbot_bringup/launch/robot.launch.py")
    chosen = {part.args[0]: part.args[1] for part in description.every("SetEnvironmentVariable")}
    assert chosen[transport.RANGE] == "SYSTEM_DEFAULT"
    assert chosen[transport.PROFILES] == transport.PICTURES
    kinds = [type(part).__name__ for part in description.args[0]]
    assert kinds.index("SetEnvironmentVariable") < kinds.index("GroupAction")


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_parameters_given_to_our_nodes_are_known(file, run):
    """Keys of the dictionaries in a launch file are keys of the node's YAML file."""
    import yaml

    for node in run(file).every("LifecycleNode"):
        package, name = node.kwargs["package"], node.kwargs["executable"]
        document = yaml.safe_load((ROOT / package / "config" / f"{name}.yaml").read_text(encoding="utf-8"))
        known = {*next(iter(document.values()))["ros__parameters"], "autostart", "use_sim_time"}
        for entry in node.kwargs["parameters"]:
            if isinstance(entry, dict):
                assert entry.keys() <= known
