"""How the driver's diagnostic is summed up."""

import math
from types import SimpleNamespace

import pytest
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.arm.states import QUIET, Alarm, Reaction, State
from bathbot_scrub.rm65.driver import Snapshot
from bathbot_scrub.rm65.ros.telemetry import health

REGION = shipped_force_limits().gentlest()
STARVES = Alarm("queue_starvation", Reaction.TELL, "the arm waits for segments")


def snapshot(state=State.CONTACT, reason="", connected=True, force=math.nan):
    return Snapshot(state, reason, connected, 1, 0, 0, 0.0, False, force, 10.0, 0.01, 0.0)


def driver(*alarms, moving=False):
    guard = SimpleNamespace(region=REGION)
    return SimpleNamespace(loop=SimpleNamespace(alarms=alarms, guard=guard, moving=moving))


@pytest.mark.parametrize(("told", "alarms", "refused", "expected"), [
    pytest.param(snapshot(), (QUIET,), "", (True, False, "CONTACT"), id="nothing to tell: its state"),
    pytest.param(snapshot(reason="path done"), (), "", (True, False, "path done"), id="its reason"),
    pytest.param(snapshot(), (STARVES,), "", (True, True, STARVES.message), id="a warning"),
    pytest.param(snapshot(reason="paused"), (STARVES,), "", (True, True, "paused"), id="reason first"),
    pytest.param(snapshot(reason="paused"), (), "too far", (True, True, "too far"), id="a segment refused"),
    pytest.param(snapshot(State.FAULT, "lost"), (), "", (False, False, "lost"), id="fault"),
    pytest.param(snapshot(connected=False), (), "", (False, False, "CONTACT"), id="no connection"),
])  # fmt: skip
def test_the_gravest_is_told(told, alarms, refused, expected):
    assert health(driver(*alarms), told, refused) == expected


def test_a_brush_that_presses_too_hard_while_it_scrubs_is_a_warning():
    found = health(driver(moving=True), snapshot(force=REGION.comfort[1] + 1.0), "")
    assert found.doubtful
    assert "above the comfort band" in found.message
    assert not health(driver(moving=False), snapshot(force=REGION.comfort[1] + 1.0), "").doubtful
