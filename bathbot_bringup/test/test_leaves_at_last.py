"""A driver that is ended takes the head off the skin first; driver and arm live in virtual time."""

import pytest
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import VirtualCell, ready_deg
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_scrub.arm.errors import CanceledError
from bathbot_scrub.arm.states import State

READY = {"home_deg": ready_deg(0.08), "standoff": 0.03, "approach_speed": 0.05}


def cell_in_contact(region="Trunk_skin"):
    cell = VirtualCell(region, **READY)
    cell.approach()
    cell.wait(0.3)
    return cell


def close(cell):
    """Close the driver; give how long that took [s]."""
    begin = cell.clock()
    cell.driver.close()
    return cell.clock() - begin


@pytest.mark.parametrize("doing", ["standing", "scrubbing", "paused", "stopped"])
def test_who_leans_in_after_the_end_meets_nothing(doing):
    cell = cell_in_contact()
    if doing != "standing":
        cell.scrub()
        cell.wait(1.0)
    if doing in ("paused", "stopped"):
        (cell.driver.pause if doing == "paused" else cell.driver.stop)()
        cell.wait(0.3)
    assert close(cell) < 2.0
    assert cell.gap() > 0.05
    ended = cell.clock()
    cell.wait(0.5)
    cell.lean(0.04, 0.1)
    cell.wait(1.0)
    assert cell.peak(ended) == 0.0


def test_a_fault_of_the_force_does_not_keep_the_head_on_the_skin():
    cell = cell_in_contact()
    cell.order(Fault("frozen_force"))
    cell.wait(0.3)
    assert cell.state() is State.FAULT
    close(cell)
    assert cell.gap() > 0.05


@pytest.mark.parametrize("kind", ["lost_udp", "joint_error", "dropped_tcp"])
def test_joints_in_doubt_end_in_an_arm_that_stands_and_says_so_and_not_later(kind):
    cell = cell_in_contact()
    cell.order(Fault(kind))
    cell.wait(1.0)
    before = cell.gap()
    assert close(cell) < 4.0
    assert cell.gap() == pytest.approx(before, abs=1e-3)
    assert "may still be on the skin" in cell.log[-1]


def test_a_search_that_was_ended_leaves_too_and_an_arm_in_free_air_stays():
    cell = VirtualCell("Trunk_skin", **READY)
    stood = cell.controller.T_base_head[:3, 3]
    close(cell)
    assert cell.controller.T_base_head[:3, 3] == pytest.approx(stood, abs=1e-4)
    cell = VirtualCell("Trunk_skin", **READY)
    cell.clock.at(cell.clock() + 2.2, cell.driver.close)
    with pytest.raises(CanceledError):
        cell.approach()
    assert cell.gap() > 0.03
