"""Sleep of the machine is time that has passed: what was seen before is old, and a job is over."""

import time

import numpy as np
import pytest
from arm_poses import ARM
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.paths.surroundings import Surroundings
from bathbot_scrub.rm65.settings import DriverSettings
from bathbot_scrub.rm65.timing.clock import Clock
from loop_cell import LoopCell


@pytest.fixture
def machine(monkeypatch):
    """The clocks of a machine: the one that stands while it sleeps, and the one that does not."""
    clocks = {time.CLOCK_MONOTONIC: 50.0, time.CLOCK_BOOTTIME: 70.0}
    monkeypatch.setattr(time, "clock_gettime", clocks.__getitem__)
    monkeypatch.setattr(time, "monotonic", lambda: clocks[time.CLOCK_MONOTONIC])
    return clocks


def test_a_body_seen_before_the_machine_slept_is_old(machine):
    clock = Clock()
    around = Surroundings(ARM, DriverSettings(), clock)
    around.see(np.zeros((1, 3)), clock())
    around.trust()
    machine[time.CLOCK_BOOTTIME] += 3600.0
    with pytest.raises(NotReadyError, match=r"3600\.0 s ago"):
        around.trust()


@pytest.mark.parametrize("paused", [False, True])
def test_a_driver_that_was_on_its_way_wakes_up_in_fault(paused):
    cell = LoopCell()
    cell.on_the_way()
    cell.step(20)
    if paused:
        cell.loop.guard.pause()
        cell.loop.motion.brake()
        cell.until(lambda: not cell.loop.moving)
    cell.now += 3600.0
    cell.step()
    assert cell.state is State.FAULT
    assert "stood still for 3600" in cell.loop.guard.reason
    told = len(cell.link.told_joints)
    cell.step(100)
    assert np.ptp(cell.link.told_joints[told:], axis=0).max() == 0.0


def test_a_driver_that_was_stopped_while_it_judged_commands_nothing_of_before(monkeypatch):
    """Most of a period that is not waited is spent on judging: there the process is caught."""
    cell = LoopCell()
    cell.on_the_way()
    cell.step(20)
    sense, told = cell.link.sense, len(cell.link.told_joints)

    def asleep(now):
        cell.now += 0.5
        monkeypatch.setattr(cell.link, "sense", sense)
        return sense(now)

    monkeypatch.setattr(cell.link, "sense", asleep)
    before = cell.link.told_joints[-1]
    cell.step()
    assert cell.state is State.FAULT
    assert "stood still for 0.50" in cell.loop.guard.reason
    cell.step(100)
    assert np.abs(np.array(cell.link.told_joints[told:]) - before).max() == 0.0
