"""A driver that is started again with the brush on somebody; virtual time, judged by the true force."""

import pytest
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import VirtualCell, ready_deg
from bathbot_bringup.evaluation.safety.virtual.virtual_link import VirtualLink
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.states import State
from bathbot_scrub.rm65.driver import ArmDriver

PRESS = 0.0068  # [m] by which the person leans in: the give is used up, and a little skin


def started_again(cell):
    """Put a new driver in the place of the one that died; controller and sensor know nothing of it."""
    cell.link = VirtualLink(cell.settings, cell._desk, cell.clock, cell.link._wires)
    arm = cell.driver.arm
    cell.driver = ArmDriver(cell.settings, cell.limits, arm, cell.link, cell.log.append, cell.clock)
    cell._start()
    assert cell.clock.until(lambda: cell.driver.snapshot().connected, 1.0)
    return cell.driver


@pytest.fixture
def cell():
    cell = VirtualCell("Trunk_skin", 1, home_deg=ready_deg(0.10), leave_after=3.0)
    assert cell.state() is State.FREE  # at home, it needs nobody
    cell.approach()
    cell.wait(0.5)
    return cell


def test_it_holds_zeroes_nothing_and_goes_nowhere_until_somebody_says_what_touches(cell):
    driver = started_again(cell)
    cell.lean(PRESS, 0.02)
    cell.wait(1.0)
    pressed = cell.force()
    assert pressed > 8.0
    assert driver.snapshot().state is State.HOLD
    assert "arm/resume" in driver.snapshot().reason
    for refused in (driver.zero_force, cell.approach, driver.home):
        with pytest.raises(NotReadyError, match="nobody has said that nothing touches the head"):
            refused()
    cell.wait(4.0)  # no watchdog moves it either: what the sensor's zero is worth is not known
    assert cell.force() == pytest.approx(pressed, abs=0.1)
    driver.retract()
    cell.wait(2.0)
    assert cell.gap() > 0.05
    with pytest.raises(NotReadyError, match="arm/resume"):
        cell.approach()
    driver.resume()
    driver.zero_force()


def test_a_person_who_is_pressed_is_not_zeroed_away_even_when_somebody_errs(cell):
    """Called free by mistake: the first zeroing of the new driver is bound like all others."""
    driver = started_again(cell)
    cell.lean(PRESS, 0.02)
    cell.wait(1.0)
    driver.resume()
    with pytest.raises(NotReadyError, match="where nothing should be"):
        driver.zero_force()
    assert driver.snapshot().force > 8.0


def test_within_the_deadline_somebody_must_look_again_or_it_holds(cell):
    """Free by somebody's word, pressed all the same: idle contact is watched in FREE, too."""
    driver = started_again(cell)
    cell.lean(PRESS, 0.02)
    driver.resume()
    cell.wait(driver.settings.leave_after + 1.0)
    assert driver.snapshot().state is State.HOLD
    assert "felt where nothing should be" in driver.snapshot().reason
