"""Every number of the limits file acts: changed, it changes a decision of guard, zeroing or planner."""

import re

import numpy as np
import pytest
import yaml
from bathbot_scrub.arm.errors import ArmError
from bathbot_scrub.arm.force_limits import default_file, load_force_limits
from bathbot_scrub.arm.states import QUIET, State
from bathbot_scrub.rm65.force.wrench_filter import Trend
from bathbot_scrub.rm65.guard.force_checks import Reading, comfort, limit_passed, surge
from bathbot_scrub.rm65.guard.force_guard import ForceGuard

CONTENT = yaml.safe_load(default_file().read_text(encoding="utf-8"))
SINGLE = [key for key in CONTENT if key != "regions"]
ENTRIES = [
    (region, key, index)
    for region, entry in CONTENT["regions"].items()
    for key, value in entry.items()
    for index in (range(len(value)) if isinstance(value, list) else [None])
]


def pressed(*force, torque=0.0):
    return np.array([*force, torque, 0.0, 0.0])


def reading(force):
    wrench = pressed(0.0, 0.0, -force)
    return Reading(0.0, wrench, wrench, wrench, (), 0.0)


def leaves(limits, force, rise, count=5):
    """Whether a force that rises makes the arm leave, seen over so many samples."""
    return bool(surge((Trend(count, 0.005 * (count - 1), force, rise),), limits, True))


def kind(words):
    """Which limit it was, without the numbers."""
    return re.sub(r"[\d.]+", "", words)


def felt_at(limits):
    """Force at which a search ends in contact."""
    for force in np.arange(0.05, 3.0, 0.05):
        guard = ForceGuard(limits)
        guard.vouch("at home")
        guard.begin_approach(limits.region("Trunk_skin"))
        guard.begin_seeking()
        guard.check(reading(force), QUIET, True)
        if guard.state is State.CONTACT:
            return float(force)
    return None


def zeroed(limits, residual):
    try:
        limits.check_zeroed(residual)
    except ArmError:
        return False
    return True


def decisions(limits, name):
    """What is decided about a region, over forces, torques and rises of all sizes."""
    region, trunk = limits.region(name), limits.region("Trunk_skin")
    small, large = np.arange(0.0, 20.0, 0.1), np.arange(20.0, 170.0, 0.5)
    return [
        [kind(limit_passed(pressed(0.0, 0.0, -force), region)) for force in [*small, *large]],
        [kind(limit_passed(pressed(force, 0.0, 0.0), region)) for force in small],
        [kind(limit_passed(pressed(0.0, force, 0.0), region)) for force in small],
        [kind(limit_passed(pressed(0.3 * force, 0.0, 0.95 * force), region)) for force in small],
        [kind(limit_passed(pressed(0.0, 0.0, 0.0, torque=t), region)) for t in np.arange(0.0, 0.5, 0.005)],
        [kind(limit_passed(pressed(0.0, 0.0, -force), trunk, limits.transit)) for force in small],
        [round(comfort(force, region).speed, 6) for force in small],
        [kind(comfort(force, region).word) for force in small],
        [leaves(limits, 1.2, rise) for rise in np.arange(0.0, 60.0, 0.5)],
        [leaves(limits, 3.0, rise) for rise in np.arange(0.0, 60.0, 0.5)],
        [leaves(limits, 3.0, rise, 17) for rise in np.arange(0.0, 60.0, 0.5)],
        [leaves(limits, force, 0.0) for force in np.arange(0.0, 6.0, 0.02)],
        [round(limits.comfortable(name, wanted), 6) for wanted in np.arange(0.0, 0.010, 0.0005)],
        [zeroed(limits, residual) for residual in np.arange(0.0, 1.0, 0.01)],
        felt_at(limits),
    ]


def changed(tmp_path, content):
    file = tmp_path / "limits.yaml"
    file.write_text(yaml.safe_dump(content), encoding="utf-8")
    return load_force_limits(file)


@pytest.mark.parametrize("key", SINGLE)
@pytest.mark.parametrize("factor", [0.8, 1.2], ids=["less", "more"])
def test_each_number_for_all_regions_changes_a_decision(tmp_path, key, factor):
    limits = changed(tmp_path, CONTENT | {key: factor * CONTENT[key]})
    assert decisions(limits, "Trunk_skin") != decisions(load_force_limits(), "Trunk_skin")


@pytest.mark.parametrize(("region", "key", "index"), ENTRIES)
def test_each_number_of_a_region_changes_a_decision_there_and_nowhere_else(tmp_path, region, key, index):
    content = yaml.safe_load(default_file().read_text(encoding="utf-8"))
    entry = content["regions"][region]
    if index is None:
        entry[key] *= 0.9
    else:
        entry[key][index] *= 0.9
    limits, shipped = changed(tmp_path, content), load_force_limits()
    assert decisions(limits, region) != decisions(shipped, region)
    if region == "Foot_skin":
        assert decisions(limits, "Face_skin") == decisions(shipped, "Face_skin")


def test_collision_is_an_outer_bound_for_whoever_writes_the_file(tmp_path):
    content = yaml.safe_load(default_file().read_text(encoding="utf-8"))
    content["regions"]["Face_skin"]["hard_stop"] = content["regions"]["Face_skin"]["collision"]
    with pytest.raises(ArmError, match="hard_stop < collision"):
        changed(tmp_path, content)
