"""docs/recipes.md names only what exists; where a program can follow a recipe, a test does."""

import pkgutil
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from bathbot_bringup.command import node
from bathbot_bringup.sim.faults import kinds
from bathbot_bringup.sim.faults.fault_schedule import FaultSchedule
from bathbot_bringup.sim.faults.faults import read_fault
from bathbot_bringup.sim.faults.force_faults import ForceHistory, ForceReading
from bathbot_bringup.sim.faults.kinds import Kind
from bathbot_bringup.sim.faults.lasting_fault import Place
from bathbot_scrub.arm.force_limits import load_force_limits
from bathbot_scrub.arm.states import QUIET, Action
from bathbot_scrub.rm65.guard.force_checks import Reading
from bathbot_scrub.rm65.guard.force_guard import ForceGuard

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/recipes.md").read_text(encoding="utf-8")
QUOTED = re.findall(r"`([^`\n]+)`", PAGE)
DOTTED = sorted({name for name in QUOTED if re.fullmatch(r"bathbot_\w+(\.\w+)+", name)})
PATHS = sorted({name for name in QUOTED if re.fullmatch(r"bathbot_\w+(/[\w.]+)+/?", name)})
TESTS = sorted({name for name in QUOTED if re.fullmatch(r"test_\w+", name)})
PAGES = sorted({name for name in QUOTED if re.fullmatch(r"\w+\.md", name)})


@pytest.mark.parametrize("name", DOTTED)
def test_the_name_exists(name):
    assert pkgutil.resolve_name(name) is not None


@pytest.mark.parametrize("path", PATHS)
def test_the_path_exists(path):
    package, _, rest = path.partition("/")
    assert any((ROOT / package / inner / rest).exists() for inner in ("", package))


@pytest.mark.parametrize("name", TESTS)
def test_the_test_exists(name):
    files = [*ROOT.glob("bathbot_*/test/test_*.py"), *ROOT.glob("test/test_*.py")]
    assert any(f"def {name}(" in path.read_text(encoding="utf-8") for path in files)


@pytest.mark.parametrize("name", PAGES)
def test_the_page_exists(name):
    assert (ROOT / "docs" / name).is_file()


def test_each_recipe_has_at_most_ten_lines():
    """Ten lines of text; the heading and empty lines do not count."""
    recipes = PAGE.split("\n## ")[1:]
    assert len(recipes) == 6
    for recipe in recipes:
        lines = [line for line in recipe.splitlines()[1:] if line.strip()]
        steps = [line for line in lines if re.match(r"\d\. ", line)]
        assert len(steps) <= 5, recipe
        assert len(lines) <= 10, recipe


def test_a_new_fault_is_one_row(monkeypatch):
    """A sensor that reads twice the force: ordered by its name, listed in the help, acting at the sensor."""

    def doubled(fault, said: ForceReading, history: ForceHistory) -> ForceReading:
        return said._replace(raw=fault.value * said.raw)

    row = Kind("the force sensor reads `value` times the force", {Place.FORCE_SENSOR: doubled}, 2.0, 1.0, 9.0)
    monkeypatch.setitem(kinds.KINDS, "doubled_force", row)
    assert "doubled_force" in node.fault_kinds()
    schedule = FaultSchedule()
    schedule.order(read_fault("{kind: doubled_force, value: 3}"), 0.0)
    schedule.update(0.0)
    said = ForceReading(np.arange(6.0), np.zeros(6))
    (fault,) = schedule.at(Place.FORCE_SENSOR)
    assert fault(said, ForceHistory(0.005)).raw.tolist() == [0.0, 3.0, 6.0, 9.0, 12.0, 15.0]
    assert schedule.at(Place.PUSH) == []


@pytest.mark.parametrize(("threshold", "action"), [(10.0, Action.GO_ON), (5.0, Action.RETRACT)])
def test_the_threshold_decides_where_the_recipe_says(threshold, action, tmp_path):
    """A trunk pressed with 6 N: the number in the file decides, by `ForceGuard.check`."""
    document = yaml.safe_load((ROOT / "bathbot_scrub/config/force_limits.yaml").read_text(encoding="utf-8"))
    document["regions"]["Trunk_skin"] |= {"comfort": [1.0, 4.0], "retract": threshold}
    file = tmp_path / "force_limits.yaml"
    file.write_text(yaml.safe_dump(document), encoding="utf-8")
    limits = load_force_limits(file)
    guard = ForceGuard(limits)
    guard.vouch("at home")
    guard.begin_approach(limits.region("Trunk_skin"))
    guard.begin_seeking()
    assert [guard.check(pressed(force), QUIET, False) for force in (1.5, 6.0)] == [Action.STOP, action]


def pressed(force: float) -> Reading:
    """A steady force [N] on the tip of the head."""
    wrench = np.array([0.0, 0.0, -force, 0.0, 0.0, 0.0])
    return Reading(0.0, wrench, wrench, wrench, (), 0.005)
