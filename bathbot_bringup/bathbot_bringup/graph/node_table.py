"""The nodes of the graph: which module runs one, and how gently."""

import difflib
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from bathbot_bringup.errors import InputError
from bathbot_bringup.graph.installation import config_file

Parameters = Mapping[str, object]
"""Parameters of one node, above those of its YAML file."""


class NodeEntry(NamedTuple):
    """One node: its name, its module, and its scheduling niceness (the arm's is 0)."""

    name: str
    module: str
    niceness: int
    about: str
    last: bool = False  # whether it ends only when the others have: they need it to end in order

    @property
    def package(self) -> str:
        """Name of the package the module belongs to."""
        return self.module.split(".")[0]

    @property
    def parameter_file(self) -> Path:
        """YAML file with the node's default parameters."""
        return config_file(self.package, f"{self.name}.yaml")


NODES = {
    entry.name: entry
    for entry in (
        NodeEntry("sim_rm65", "bathbot_bringup.sim.arm.sim_rm65_node", 0, "simulated RM65 controller", True),
        NodeEntry("rm65_driver", "bathbot_scrub.rm65.ros.rm65_driver_node", 0, "arm and force guard"),
        NodeEntry("scrub_planner", "bathbot_scrub.scrub_planner_node", 5, "scrub path in segments"),
        NodeEntry("target_localizer", "bathbot_localize.target_localizer_node", 5, "pixel to pose"),
        NodeEntry("recorder", "bathbot_bringup.bag.recording.recorder_node", 5, "writes a bag"),
        NodeEntry("depth_corrector", "bathbot_depthcorr.live.depth_corrector_node", 5, "corrects depth"),
        NodeEntry("skin_detector", "bathbot_perception.skin_detector_node", 10, "finds bare skin"),
        NodeEntry("sim_camera", "bathbot_bringup.sim.camera.sim_camera_node", 5, "simulated D455"),
        NodeEntry("replayer", "bathbot_bringup.bag.replaying.replayer_node", 5, "publishes a bag again"),
    )
}


def find_node(name: str) -> NodeEntry:
    """Look a node up by its name.

    Raises:
        InputError: On an unknown name; the message lists the names that exist.
    """
    if name not in NODES:
        close = difflib.get_close_matches(name, NODES, n=1)
        hint = f"did you mean {close[0]}? " if close else ""
        raise InputError(f"no node is named {name!r}; {hint}there are {', '.join(sorted(NODES))}")
    return NODES[name]


def node_command(entry: NodeEntry, parameters: Parameters | None = None) -> list[str]:
    """Build the command line that runs a node with its YAML file and, above it, `parameters`."""
    command = [sys.executable, "-m", entry.module, "--ros-args", "-r", f"__node:={entry.name}"]
    command += ["--params-file", str(entry.parameter_file)]
    for key, value in (parameters or {}).items():
        command += ["-p", f"{key}:={_yaml_scalar(value)}"]
    return command


def _yaml_scalar(value: object) -> str:
    """Write a parameter so that ROS reads back the same type: quoted text, dotted floats."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str | Path):
        return "'" + str(value).replace("'", "''") + "'"
    if isinstance(value, float):
        text = repr(value)
        return text if any(mark in text for mark in ".ein") else f"{text}.0"
    return str(value)
