"""The page on safety says what the code does."""

import re
from pathlib import Path

from bathbot_depthcorr.node.parameters import declared
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.arm.states import TRANSITIONS
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from bathbot_scrub.rm65.guard.watchdogs import WATCHDOGS
from bathbot_scrub.rm65.settings import DriverSettings

PAGE = (Path(__file__).parents[2] / "docs" / "safety.md").read_text(encoding="utf-8")


def test_the_diagram_shows_every_transition_and_no_other():
    drawn = re.findall(r"^    ([A-Z]+) --> ([A-Z]+): (.+)$", PAGE, re.MULTILINE)
    assert drawn == [(way.before.name, way.after.name, way.because) for way in TRANSITIONS]


def test_the_diagram_begins_where_the_guard_does():
    begun = ForceGuard(shipped_force_limits()).state.name
    assert re.findall(r"^    \[\*\] --> ([A-Z]+)", PAGE, re.MULTILINE) == [begun]


def test_the_table_shows_every_watchdog_and_no_other():
    head = "| name | watches | deadline | reaction |"
    rows = PAGE.split(head)[1].split("\n\n")[0].strip().splitlines()[1:]
    shown = [tuple(cell.strip() for cell in row.strip("|").split("|")) for row in rows]
    assert shown == [(dog.name, dog.watches, dog.deadline, dog.reaction.name) for dog in WATCHDOGS]


def test_the_table_of_bounds_is_that_of_the_settings():
    section = PAGE.split("## Bounds of what can be set")[1].split("\n## ")[0]
    settings, told = declared(DriverSettings), set()
    for line in re.findall(r"^\| `.*", section, re.MULTILINE):
        names, bounds, _ = (cell.strip() for cell in line.strip("|").split("|"))
        numbers = [float(number) for number in re.findall(r"(?<![\^\d.])\d+(?:\.\d+)?", bounds)]
        for name, number in zip(re.findall(r"`(\w+)`", names), numbers, strict=True):
            end = settings[name].least if "at least" in bounds else settings[name].most
            assert number == end, name
            told.add(name)
    assert len(told) > 20
