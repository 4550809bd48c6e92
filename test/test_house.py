"""The rooms of docs/architecture.md: small enough to hold in mind, without circles, drawn as they are."""

import ast
from collections import defaultdict
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = (
    "bathbot_depthcorr", "bathbot_perception", "bathbot_localize", "bathbot_scrub", "bathbot_bringup",
)  # fmt: skip
NAMES, LINES, SHORT_LINES = 12, 400, 40
PAGE = ROOT / "docs" / "architecture.md"
SHORT = {
    "bathbot_depthcorr/errors.py": "list of errors",
    "bathbot_depthcorr/live/frame_pace.py": "what the clock decides, which stands alone",
    "bathbot_depthcorr/models/ripple.py": "an equation that stands alone, used by two models",
    "bathbot_depthcorr/node/diagnostic_node.py": "a type that stands alone",
    "bathbot_depthcorr/ros/verdict.py": "a type that stands alone",
    "bathbot_depthcorr/ros/camera_health.py": "knows how the RealSense driver names things",
    "bathbot_perception/classes.py": "table of the classes",
    "bathbot_perception/errors.py": "list of errors",
    "bathbot_perception/detection/nms.py": "an algorithm that stands alone",
    "bathbot_perception/detection/smoothing.py": "an algorithm that stands alone",
    "bathbot_perception/pictures/draw.py": "table of the classes' colours, and what paints with it",
    "bathbot_perception/pictures/splits.py": "the rule by which photos are held out",
    "bathbot_localize/errors.py": "list of errors",
    "bathbot_localize/regions.py": "the type that messages and cores share",
    "bathbot_localize/target/schedule.py": "an algorithm that stands alone",
    "bathbot_scrub/arm/collision_speed.py": "equations that stand alone",
    "bathbot_scrub/rm65/arm/capsules.py": "table of the arm's capsules",
    "bathbot_scrub/rm65/arm/limits.py": "table of the arm's limits, and its home",
    "bathbot_scrub/installed_arm.py": "the one place that names the arm",
    "bathbot_scrub/rm65/guard/condition.py": "the type that guard and its search share",
    "bathbot_scrub/rm65/timing/clock.py": "time, which all of the driver shares",
    "bathbot_scrub/rm65/timing/priority.py": "what may be asked of the scheduler; three share it",
    "bathbot_bringup/sim/faults/lasting_fault.py": "the type that schedule and places share",
    "bathbot_bringup/bench/machine.py": "what a time was measured on; four share it",
    "bathbot_bringup/bathing/nodes.py": "table of the demo's nodes and their parameters",
    "bathbot_bringup/evaluation/depth/conditions.py": "table of the conditions",
    "bathbot_scrub/rm65/ros/vendor/installed.py": "the only import that may fail",
    "bathbot_scrub/segment/messages.py": "its codec",
    "bathbot_scrub/path/triangle_normals.py": "Eqs. (11)-(13), which stand alone",
    "bathbot_bringup/evaluation/safety/virtual/wire.py": "latency and jitter, which stand alone",
    "bathbot_bringup/bag/recording/recorder_qos_node.py": "DDS's offers, in rosbag2's words",
    "bathbot_bringup/bag/recording/recorder_settings.py": "settings",
    "bathbot_bringup/bag/recording/sender_counts.py": "a law that stands alone",
}
"""Files below 40 lines, and why: a table, errors, settings, or an equation or type that stands alone."""


def folders() -> list[Path]:
    """Every folder of the packages that holds modules, the packages from the source to the mouth."""
    return [
        folder
        for package in PACKAGES
        for folder in sorted({module.parent for module in (ROOT / package / package).rglob("*.py")})
    ]


def modules() -> dict[str, Path]:
    """Every module by its dotted name; a folder's `__init__` goes by the folder's name."""
    found = {}
    for package in PACKAGES:
        for file in sorted((ROOT / package / package).rglob("*.py")):
            parts = file.relative_to(ROOT / package).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


MODULES = modules()


def imported(file: Path) -> set[str]:
    """Our modules that a file imports, anywhere in it."""
    names = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                names.add(whole if whole in MODULES else node.module)
    return names & set(MODULES)


@cache
def imports() -> dict[str, set[str]]:
    """What every module imports of ours."""
    return {name: imported(file) for name, file in MODULES.items()}


def length(file: Path) -> int:
    """Lines of a file."""
    return len(file.read_text(encoding="utf-8").splitlines())


def place(file: Path) -> str:
    """Path below the outer folder of the package, as the lists here name it."""
    return "/".join(file.relative_to(ROOT).parts[1:])


def picture() -> str:
    """Draw the folders: one line each, with the first sentence of the folder's docstring."""
    lines = []
    for folder in folders():
        parts = folder.relative_to(ROOT).parts[1:]
        about = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
        name = "    " * (len(parts) - 1) + parts[-1] + "/"
        lines.append(f"{name:<27} {about.splitlines()[0] if about else 'SAYS NOTHING'}".rstrip())
    return "\n".join(lines)


@pytest.mark.parametrize("folder", folders(), ids=place)
def test_a_folder_can_be_held_in_mind(folder):
    files = {file for file in folder.rglob("*") if file.is_file() and "__pycache__" not in file.parts}
    names = {file.relative_to(folder).parts[0] for file in files} - {"__init__.py"}
    assert len(names) <= NAMES, sorted(names)


def test_no_file_is_too_long():
    assert {place(file): length(file) for file in MODULES.values() if length(file) > LINES} == {}


def test_every_short_file_has_a_reason():
    short = {
        place(file) for file in MODULES.values() if length(file) < SHORT_LINES and file.name != "__init__.py"
    }
    assert short - set(SHORT) == set(), "merge it into what uses it, or say why it stands alone"
    assert set(SHORT) - short == set(), "no longer short, or gone: strike it from the list"


@pytest.mark.parametrize("folder", folders(), ids=place)
def test_what_stands_side_by_side_imports_one_way(folder):
    """Files and folders of one folder, each with all that is in it, import one another without a circle."""
    prefix = ".".join(folder.relative_to(ROOT).parts[1:]) + "."
    graph = defaultdict(set)
    for module, used in imports().items():
        for other in used:
            if module.startswith(prefix) and other.startswith(prefix):
                mine, theirs = (name.removeprefix(prefix).split(".")[0] for name in (module, other))
                if mine != theirs:
                    graph[mine].add(theirs)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"a circle: {' <- '.join(error.args[1])}")


def test_no_circle_of_files():
    TopologicalSorter({name: used - {name} for name, used in imports().items()}).prepare()


def test_the_page_draws_the_folders_as_they_are():
    drawn = PAGE.read_text(encoding="utf-8").partition("```folders\n")[2].partition("\n```")[0]
    assert drawn == picture()
