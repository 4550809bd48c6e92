"""The architecture of docs/architecture.md, held against every import of the tree."""

import ast
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).parents[1]
UPSTREAM = {
    "bathbot_depthcorr": set(),
    "bathbot_perception": {"bathbot_depthcorr"},
    "bathbot_localize": {"bathbot_depthcorr"},
    "bathbot_scrub": {"bathbot_depthcorr", "bathbot_localize"},
    "bathbot_bringup": {"bathbot_depthcorr", "bathbot_perception", "bathbot_localize", "bathbot_scrub"},
}
# The detector is a branch of its own: of the first stage it takes the frame of a node and the one writer of
# files, nothing of depth.
PERCEPTION_TAKES = {
    "errors", "files", "node.newest_worker", "node.parameters", "node.process_node", "node.stage_node",
}  # fmt: skip
INTERFACES = {
    "action_msgs",
    "bathbot_msgs",
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "lifecycle_msgs",
    "nav_msgs",
    "rcl_interfaces",
    "realsense2_camera_msgs",
    "rosgraph_msgs",
    "sensor_msgs",
    "std_msgs",
    "std_srvs",
    "tf2_msgs",
    "trajectory_msgs",
    "vision_msgs",
}
# As rosdep calls what Python calls otherwise; what only PyPI has stands in the README.
ROSDEP = {
    "PIL": "python3-pil",
    "cryptography": "python3-cryptography",
    "cv2": "python3-opencv",
    "launch": "launch",
    "launch_ros": "launch_ros",
    "matplotlib": "python3-matplotlib",
    "numpy": "python3-numpy",
    "pinocchio": "pinocchio",
    "rclpy": "rclpy",
    "scipy": "python3-scipy",
    "yaml": "python3-yaml",
}
# The arm is named once; the rest takes `bathbot_scrub.arm.arm.Arm`.
KNOW_THE_RM65 = {
    "bathbot_scrub/installed_arm.py": "the one place that names the arm",
    "bathbot_bringup/graph/node_table.py": "table of all nodes and their modules",
    "bathbot_bringup/bench/ik.py": "measures the closed form of this arm beside two libraries",
    "bathbot_bringup/calibration/scenes.py": "moves the emulated arm over the vendor's protocol",
    "bathbot_bringup/evaluation/safety/trial/trial_graph.py": "moves the emulated arm, likewise",
    "bathbot_bringup/evaluation/safety/trial/trial_run.py": "waits for what this driver says",
}
MODULES = [
    module
    for package in UPSTREAM
    for module in sorted((ROOT / package / package).rglob("*.py"))
    if "__pycache__" not in module.parts
]


@cache
def imports(module: Path) -> set[str]:
    """Dotted names of all modules that a file imports, anywhere in it."""
    found = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def test_there_are_modules():
    assert {module.relative_to(ROOT).parts[0] for module in MODULES} == set(UPSTREAM)


def test_imports_flow_one_way():
    wrong = {}
    for module in MODULES:
        package = module.relative_to(ROOT).parts[0]
        used = {name.split(".")[0] for name in imports(module)}
        ours = {name for name in used if name.startswith("bathbot_")} - {"bathbot_msgs"}
        if not ours <= UPSTREAM[package] | {package}:
            wrong[str(module.relative_to(ROOT))] = ours
    assert not wrong


def test_a_package_declares_what_it_imports():
    """colcon and rosdep read package.xml; what another package happens to bring may be gone tomorrow."""
    names = {name: name for name in INTERFACES | set(UPSTREAM)} | ROSDEP
    missing = {}
    for package in UPSTREAM:
        files = [*(ROOT / package / package).rglob("*.py"), *(ROOT / package / "launch").glob("*.py")]
        used = {name.split(".")[0] for file in files for name in imports(file)} & set(names) - {package}
        manifest = ElementTree.parse(ROOT / package / "package.xml")
        declared = {entry.text for entry in manifest.iter("exec_depend")}
        missing[package] = sorted({names[name] for name in used} - declared)
    assert missing == {package: [] for package in UPSTREAM}


def test_only_nodes_know_ros():
    wrong = {}
    for module in MODULES:
        used = {name.split(".")[0] for name in imports(module)}
        foreign = {"rclpy"} if module.stem == "messages" else INTERFACES | {"rclpy"}
        ros = set() if module.stem.endswith("_node") else used & foreign
        if ros:
            wrong[str(module.relative_to(ROOT))] = ros
    assert not wrong


def test_perception_takes_only_the_frame_of_a_node():
    for module in (ROOT / "bathbot_perception/bathbot_perception").rglob("*.py"):
        taken = {
            name.removeprefix("bathbot_depthcorr.").rpartition(".")[0]
            for name in imports(module)
            if name.startswith("bathbot_depthcorr.")
        }
        assert taken <= PERCEPTION_TAKES, module


def test_a_node_file_names_no_other_package_privately():
    private = [
        (module, name) for module in MODULES for name in imports(module)
        if name.startswith("bathbot_") and any(part.startswith("_") for part in name.split("."))
    ]  # fmt: skip
    assert not private


def test_the_arm_is_named_in_one_place():
    """Nobody else names a module of rm65, but its emulator, the cell of both, and the few with a reason."""
    naming = {
        "/".join(module.relative_to(ROOT).parts[1:])
        for module in MODULES
        if "bathbot_scrub.rm65" in module.read_text(encoding="utf-8")
    }
    own = ("bathbot_scrub/rm65/", "bathbot_bringup/sim/arm/", "bathbot_bringup/evaluation/safety/virtual/")
    assert {place for place in naming if not place.startswith(own)} == set(KNOW_THE_RM65)
