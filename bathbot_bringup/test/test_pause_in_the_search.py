"""A touch while the search for skin is paused, in virtual time, judged by the true force."""

import pytest
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import VirtualCell, ready_deg
from bathbot_scrub.arm.states import State

NEAR = 0.02  # [m] before the skin, where the search is paused


@pytest.mark.parametrize(("region", "bend"), [("Face_skin", 0.006), ("Trunk_skin", 0.0035)])
def test_who_touches_a_paused_search_is_not_pressed_when_it_is_resumed(region, bend):
    """The person comes against the standing brush; the approach ends there, and nothing goes on."""
    cell = VirtualCell(region, 2, home_deg=ready_deg(0.10), leave_after=3.0)
    driver = cell.driver

    def pause():
        if not (driver.loop.guard.touching and cell.gap() < NEAR):
            return cell.after(0.01, pause)
        driver.pause()
        cell.after(0.2, lambda: cell.lean(cell.gap() + bend, 0.02))
        return cell.after(2.0, driver.resume)

    cell.after(0.0, pause)
    cell.approach()
    begun = cell.clock()
    assert cell.state() is State.CONTACT
    cell.wait(1.5)
    assert cell.state() is State.CONTACT
    assert not cell.moving()
    assert cell.peak(begun - 0.5) == pytest.approx(400.0 * bend, abs=0.1)
    cell.wait(driver.settings.leave_after)
    assert cell.gap() > 0.05
    assert cell.peak() < cell.limits.used_up
