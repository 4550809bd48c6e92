"""Somebody leans into the arm's way and no cloud says so: the true force, in virtual time."""

import pytest
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import VirtualCell
from bathbot_scrub.arm.errors import ArmError
from bathbot_scrub.arm.states import State


def seen_once(region="Face_skin", seed=0):
    cell = VirtualCell(region, seed)
    cell.driver.surroundings.see(cell.person.cloud(cell.clock()), cell.clock())
    return cell


@pytest.mark.parametrize(
    ("far", "speed", "after"),
    [
        pytest.param(0.12, 10.0, 0.3, id="there before the arm"),
        pytest.param(0.20, 0.1, 2.5, id="while the arm comes"),
        pytest.param(0.20, 0.1, 5.0, id="against the stand-off"),
        pytest.param(0.08, 0.05, 4.0, id="slowly"),
    ],
)
def test_a_face_that_leans_into_an_approach_is_hardly_pressed(far, speed, after):
    cell = seen_once()
    cell.lean(far, speed, after)
    with pytest.raises(ArmError):
        cell.approach()
    cell.wait(4.0)
    assert 0.5 < cell.peak() < 1.2 * cell.region.retract
    assert cell.state() is State.HOLD
    assert cell.gap() > 0.005


def test_a_face_that_leans_after_an_arm_on_its_way_home_is_left_not_run_into():
    """At first the way home leads on over the skin: back is not the way that gives in."""
    cell = seen_once()
    cell.approach()
    cell.wait(0.3)
    cell.driver.retract()
    cell.wait(1.0)
    home = cell.clock()
    cell.lean(0.20, 0.1)
    cell.driver.home()
    cell.wait(4.0)
    assert cell.peak(home) < 1.2 * cell.region.retract
    assert cell.gap() > 0.02
    assert cell.state() in (State.HOLD, State.FREE)


def test_an_arm_that_was_stopped_on_its_way_still_yields():
    cell = seen_once()
    cell.after(4.5, cell.driver.stop)
    with pytest.raises(ArmError):
        cell.approach()
    cell.wait(2.0)  # the stream of commands has ended, too
    stood = cell.gap()
    assert cell.driver.loop.motion.command is None
    cell.lean(stood + 0.05, 0.1)
    cell.wait(stood / 0.1 + 3.0)
    assert 0.5 < cell.peak() < 1.2 * cell.region.retract
    assert cell.gap() > 0.0
