"""A node decodes, calls and encodes: its file is short, and the frame makes and ends what it owns."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FRAME = ROOT / "bathbot_depthcorr" / "bathbot_depthcorr" / "node"
LINES = 130


def imported(file: Path) -> set[str]:
    """Names that a file imports from elsewhere."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return {alias.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names}


OF_NODES = [
    file
    for file in sorted(ROOT.glob("bathbot_*/bathbot_*/**/*_node.py"))
    if file.parent != FRAME and imported(file) & {"StageNode", "EndpointOwner"}
]


def place(file: Path) -> str:
    return str(file.relative_to(ROOT))


def test_all_nodes_are_looked_at():
    assert sum("(StageNode):" in file.read_text(encoding="utf-8") for file in OF_NODES) == 9


@pytest.mark.parametrize("file", sorted(ROOT.glob("bathbot_*/bathbot_*/**/*_node.py")), ids=place)
def test_a_node_is_short(file):
    """Whoever meets the graph, node or client of it."""
    assert len(file.read_text(encoding="utf-8").splitlines()) <= LINES


@pytest.mark.parametrize("file", OF_NODES, ids=place)
def test_a_node_neither_makes_nor_ends_endpoints_by_hand(file):
    calls = [node.func for node in ast.walk(ast.parse(file.read_text("utf-8"))) if isinstance(node, ast.Call)]
    by_hand = {
        call.attr
        for call in calls
        if isinstance(call, ast.Attribute) and call.attr.startswith(("create_", "destroy_"))
    }
    assert by_hand == set()


@pytest.mark.parametrize("file", OF_NODES, ids=place)
def test_a_node_knows_its_state_without_asking_whether_it_exists(file):
    calls = [node.func for node in ast.walk(ast.parse(file.read_text("utf-8"))) if isinstance(node, ast.Call)]
    assert not {call.id for call in calls if isinstance(call, ast.Name)} & {"hasattr", "setattr", "getattr"}
