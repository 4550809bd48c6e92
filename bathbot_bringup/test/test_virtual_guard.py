"""Force guard and watchdogs against the emulated controller with ordered faults, in virtual time."""

import numpy as np
import pytest
from bathbot_bringup.evaluation.safety.virtual.virtual_cell import AXIS
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.states import State
from emulator_cell import segments
from near_the_skin import AT_ONCE, at_last, cell_near, off_the_normal, touch
from numpy.testing import assert_allclose


@pytest.fixture
def cell():
    return cell_near()


def scrubbing(cell, speed=0.04, depth=0.004, count=3):
    touch(cell)
    for segment in segments(count, speed, depth):
        cell.driver.follow(segment)
    at_last(cell, lambda: cell.driver.snapshot().distance_along > 0.015, 2.0)


def leave(cell):
    cell.driver.retract()
    at_last(cell, lambda: cell.state() is State.FREE, 1.5)


def test_a_body_pushed_into_the_scrubbing_brush_never_uses_up_the_bristles(cell):
    scrubbing(cell)
    begin = cell.clock()
    cell.order(Fault("body_push", duration=0.6, value=0.1))
    at_last(cell, lambda: cell.state() in (State.HOLD, State.FAULT), 2.0)
    assert cell.state() is State.HOLD
    assert "rises by" in cell.driver.snapshot().reason
    assert cell.controller.contact.compression < 0.0
    assert cell.driver.loop.log.reactions.count == 1
    assert cell.peak(begin) < cell.region.hard_stop
    assert cell.trace.data().indentation.max() == 0.0
    cell.order(Fault("none"))
    with pytest.raises(NotReadyError, match="arm/resume"):
        cell.driver.home()
    cell.driver.resume()
    assert cell.state() is State.FREE


def test_a_body_nearer_than_believed_is_felt_below_the_lowest_threshold(cell):
    cell.lean(0.02, AT_ONCE)
    touch(cell, "Face_skin")
    assert 0.5 < cell.peak() < cell.limits.region("Face_skin").retract


def test_a_short_silence_makes_the_arm_wait_and_go_on_by_itself(cell):
    scrubbing(cell, speed=0.08)
    cell.order(Fault("lost_udp", duration=0.15))
    at_last(cell, lambda: cell.driver.loop.guard.waiting, 0.1)
    cell.wait(0.15 + cell.settings.steady_for - 0.1)
    assert (cell.state(), cell.moving()) == (State.CONTACT, False)
    at_last(cell, lambda: cell.driver.snapshot().path_done, 3.0)
    assert cell.state() is State.CONTACT


@pytest.mark.parametrize(
    ("kind", "told", "named"),
    [
        ("dead_force", "six-axis", "force_sensor_error"),
        ("joint_error", "joint 3, ", "joint_error"),
    ],
)
def test_what_does_not_pass_by_itself_is_a_fault_that_names_its_cause(cell, kind, told, named):
    scrubbing(cell)
    cell.order(Fault(kind))
    at_last(cell, lambda: cell.state() is State.FAULT, 0.5)
    assert told in cell.driver.snapshot().reason
    assert named in [alarm.name for alarm in cell.driver.loop.alarms]
    cell.wait(0.4)
    assert not cell.moving()
    with pytest.raises(NotReadyError, match="cannot resume"):
        cell.driver.resume()
    cell.order(Fault("none"))
    cell.wait(0.4)
    cell.driver.resume()
    assert cell.state() is State.HOLD


@pytest.mark.parametrize("seed", [0, 1, 3, 6])
def test_a_state_still_on_its_way_when_errors_are_cleared_does_not_keep_the_arm_from_resuming(seed):
    cell = touch(cell_near(seed))
    cell.order(Fault("joint_error"))
    cell.wait(0.2)
    cell.order(Fault("none"))
    cell.wait(0.4)
    cell.driver.resume()
    assert cell.state() is State.HOLD


def test_with_a_doubtful_force_an_operator_can_still_take_the_arm_off_the_skin(cell):
    scrubbing(cell)
    cell.order(Fault("frozen_force"))
    at_last(cell, lambda: cell.state() is State.FAULT, 0.5)
    cell.driver.retract()
    at_last(cell, lambda: cell.state() is State.FAULT and not cell.driver.loop.moving, 2.0)
    assert cell.gap() > 0.05
    assert off_the_normal(cell) < 0.05
    cell.order(Fault("none"))
    cell.wait(0.5)
    cell.driver.resume()
    assert cell.state() is State.HOLD


def test_an_arm_whose_planner_has_died_leaves_the_skin():
    cell = cell_near(leave_after=0.5)
    touch(cell)
    cell.driver.follow(segments()[0])
    at_last(cell, lambda: "the planner is silent" in cell.driver.snapshot().reason, 2.0)
    at_last(cell, lambda: cell.state() is State.HOLD and not cell.driver.loop.guard.touching, 1.5)
    assert cell.gap() > 0.05


def test_zeroing_is_refused_on_the_skin_and_when_something_touches(cell):
    touch(cell)
    with pytest.raises(NotReadyError, match="off the skin"):
        cell.driver.zero_force()
    leave(cell)
    cell.order(Fault("drifting_force", value=-4.0))
    at_last(cell, lambda: cell.driver.snapshot().force > 3.2, 1.5)
    with pytest.raises(NotReadyError, match="where nothing should be"):
        cell.driver.zero_force()


def test_a_sensor_that_has_drifted_is_zeroed_when_someone_vouches_for_it(cell):
    cell.driver.zero_force()
    with pytest.raises(NotReadyError, match="nothing is paused"):
        cell.driver.resume()
    cell.order(Fault("biased_force", value=-6.0))
    at_last(cell, lambda: cell.driver.snapshot().force > 5.5, 0.5)
    with pytest.raises(NotReadyError, match="arm/resume to say so"):
        touch(cell)
    cell.driver.resume()
    touch(cell)
    assert cell.driver.snapshot().force < 4.0
    leave(cell)


def test_who_follows_the_arm_is_left_only_where_the_way_is_known_to_be_free(cell):
    """Pressed again while it still leaves, with somebody close behind: it stands."""
    touch(cell)
    cell.order(Fault("biased_force", value=-12.0, duration=0.05))
    at_last(cell, lambda: cell.state() is State.RETRACTING and cell.gap() > 0.02, 1.0)
    head = cell.driver.loop.where()
    everywhere = np.stack(np.meshgrid(*[np.linspace(-0.3, 0.3, 31)] * 3), -1).reshape(-1, 3)
    around = everywhere + cell.driver.arm.head(head)[:3, 3] - 0.3 * AXIS
    cell.driver.surroundings.see(around, cell.clock())
    cell.order(Fault("biased_force", value=-20.0))
    at_last(cell, lambda: cell.state() is State.FAULT, 0.5)
    assert "the body" in cell.driver.snapshot().reason
    at_last(cell, lambda: np.abs(cell.controller.dynamics.speeds).max() < 1e-3, 0.5)
    assert cell.gap() < 0.09
    cell.wait(0.3)
    assert cell.gap() < 0.09


def test_silence_of_the_push_stops_the_arm_and_resume_clears_it(cell):
    touch(cell)
    cell.order(Fault("lost_udp"))
    at_last(cell, lambda: cell.state() is State.FAULT, 0.5)
    assert "no state from the controller" in cell.driver.snapshot().reason
    with pytest.raises(NotReadyError, match="cannot resume"):
        cell.driver.resume()
    cell.order(Fault("none"))
    at_last(cell, lambda: cell.driver.snapshot().connected, 0.5)
    cell.driver.resume()
    leave(cell)


@pytest.mark.parametrize("gives_up", [False, True])
def test_what_waits_in_front_of_a_controller_that_stood_still_is_not_obeyed_later(cell, gives_up):
    """Frames that went out before the silence was noticed wait in the controller, and a stop behind them."""
    scrubbing(cell, speed=0.08)
    cell.order(Fault("stalled"))
    at_last(cell, lambda: cell.state() is State.FAULT, 1.0)
    cell.wait(0.05)
    if gives_up:
        cell.drop_clients()
    stood = cell.controller.T_base_head[:3, 3]
    cell.order(Fault("none"))
    cell.wait(0.5)
    assert np.linalg.norm(cell.controller.T_base_head[:3, 3] - stood) < 2e-4


def test_a_driver_that_was_held_up_does_not_move_on(cell):
    """The control loop stands still for a while, as all of a process does that is stopped."""
    scrubbing(cell, speed=0.05, count=6)
    cell.hold_up(0.5)
    cell.wait(0.49)
    stood = cell.controller.dynamics.joints
    at_last(cell, lambda: cell.state() is State.FAULT, 0.05)
    assert "stood still" in cell.driver.snapshot().reason
    cell.wait(0.3)
    assert_allclose(cell.controller.dynamics.joints, stood, atol=1e-3)
