"""docs/equations.md names only functions and tests that exist, and misses no equation."""

import pkgutil
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/equations.md").read_text(encoding="utf-8")
NAMES = re.findall(r"`((?:bathbot|test)_[\w.]+)`", PAGE)
FUNCTIONS = sorted({name for name in NAMES if name.startswith("bathbot_")})
TESTS = sorted({name for name in NAMES if name.startswith("test_")})


@pytest.mark.parametrize("name", FUNCTIONS)
def test_function_exists(name):
    assert callable(pkgutil.resolve_name(name))


@pytest.mark.parametrize("name", TESTS)
def test_test_exists(name):
    files = [path for folder in ROOT.glob("bathbot_*/test") for path in folder.glob("test_*.py")]
    assert any(f"def {name}(" in path.read_text(encoding="utf-8") for path in files)


def test_all_nineteen_are_there():
    assert [int(number) for number in re.findall(r"^\| (\d+) \|", PAGE, re.MULTILINE)] == list(range(1, 20))
