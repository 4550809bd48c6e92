"""Force guard and watchdogs against the emulated controller with ordered faults, over TCP and UDP.

Only what happens is asserted, not when.
"""

import contextlib
import time

import numpy as np
import pytest
from bathbot_bringup.sim.faults.faults import Fault
from bathbot_scrub.arm.errors import ArmError, NotReadyError
from bathbot_scrub.arm.states import State
from emulator_cell import AXIS, REGION, TARGET, running, segments, until

pytestmark = pytest.mark.graph

QUICK = {"standoff": 0.03, "approach_speed": 0.06}


@pytest.fixture
def cell():
    with running(**QUICK) as cell:
        yield cell


def in_contact(cell, region=REGION):
    cell.approach(region=region)
    until(lambda: not cell.driver.loop.moving)


def scrubbing(cell, speed=0.04, depth=0.004):
    in_contact(cell)
    for segment in segments(speed=speed, depth=depth):
        cell.driver.follow(segment)
    until(lambda: cell.driver.snapshot().distance_along > 0.015)


def resumed(cell):
    """Ask until the cause is gone."""
    deadline = time.monotonic() + 20.0
    while time.monotonic() < deadline:
        try:
            return cell.driver.resume()
        except ArmError:
            time.sleep(0.02)
    raise AssertionError(cell.driver.snapshot().reason)


def leave(cell):
    cell.driver.retract()
    until(lambda: cell.state() in (State.FREE, State.FAULT))
    if cell.state() is State.FAULT:
        cell.driver.resume()


def peak_force(cell):
    """Largest true force [N] since the last call."""
    force = np.linalg.norm(cell.emulator.trace.data().force, axis=1).max()
    cell.emulator.trace.clear()
    return force


def test_a_body_pushed_into_the_scrubbing_brush_never_uses_up_the_bristles(cell):
    scrubbing(cell)
    peak_force(cell)
    cell.emulator.order(Fault("body_push", duration=0.6, value=0.1))
    until(lambda: cell.state() in (State.HOLD, State.FAULT))
    assert "rises by" in cell.driver.snapshot().reason
    until(lambda: cell.emulator.truth().contact.compression < 0.0)
    assert cell.driver.loop.log.reactions.count > 0
    assert peak_force(cell) < cell.driver.limits.region(REGION).hard_stop
    cell.emulator.order(Fault("none"))
    with pytest.raises(NotReadyError, match="arm/resume"):
        cell.driver.home()
    cell.driver.resume()
    assert cell.state() is State.FREE


def test_a_body_nearer_than_believed_is_felt_below_the_lowest_threshold(cell):
    cell.wall.shift = 0.02
    in_contact(cell, "Face_skin")
    assert peak_force(cell) < cell.driver.limits.region("Face_skin").retract


def test_a_short_silence_makes_the_arm_wait_and_go_on_by_itself(cell):
    scrubbing(cell)
    cell.emulator.order(Fault("lost_udp", duration=0.15))
    until(lambda: cell.driver.loop.guard.waiting)
    assert cell.state() is State.CONTACT
    until(lambda: cell.driver.snapshot().path_done)
    assert cell.state() is State.CONTACT


@pytest.mark.parametrize(
    ("kind", "told"),
    [("dead_force", "six-axis"), ("joint_error", "joint")],
)
def test_what_does_not_pass_by_itself_is_a_fault_that_names_its_cause(cell, kind, told):
    scrubbing(cell)
    cell.emulator.order(Fault(kind))
    until(lambda: cell.state() is State.FAULT)
    assert told in cell.driver.snapshot().reason
    with pytest.raises(NotReadyError, match="cannot resume"):
        cell.driver.resume()
    cell.emulator.order(Fault("none"))
    resumed(cell)
    assert cell.state() is State.HOLD


def test_with_a_doubtful_force_an_operator_can_still_take_the_arm_off_the_skin(cell):
    scrubbing(cell)
    cell.emulator.order(Fault("frozen_force"))
    until(lambda: cell.state() is State.FAULT)

    def off():
        if not cell.driver.loop.moving:  # a machine that stalls may stop it on the way: asked again
            with contextlib.suppress(ArmError):
                cell.driver.retract()
        return cell.gap() > 0.05

    until(off)
    until(lambda: cell.state() is State.FAULT and not cell.driver.loop.moving)
    offset = cell.emulator.truth().T_base_head[:3, 3] - TARGET[:3, 3]
    assert np.linalg.norm(np.cross(offset, AXIS)) < 0.05
    cell.emulator.order(Fault("none"))
    resumed(cell)
    assert cell.state() is State.HOLD


def test_an_arm_whose_planner_has_died_leaves_the_skin():
    with running(leave_after=0.5, **QUICK) as cell:
        in_contact(cell)
        cell.driver.follow(segments()[0])
        until(lambda: "the planner is silent" in cell.driver.snapshot().reason)
        until(lambda: cell.state() is State.HOLD and not cell.driver.loop.guard.touching)
        assert cell.gap() > 0.05


def test_zeroing_is_refused_on_the_skin_and_when_something_touches(cell):
    in_contact(cell)
    with pytest.raises(NotReadyError, match="off the skin"):
        cell.driver.zero_force()
    leave(cell)
    cell.emulator.order(Fault("drifting_force", value=-4.0))
    until(lambda: cell.driver.snapshot().force > 3.2)
    with pytest.raises(NotReadyError, match="where nothing should be"):
        cell.driver.zero_force()
    cell.emulator.order(Fault("none"))


def test_a_sensor_that_has_drifted_is_zeroed_when_someone_vouches_for_it(cell):
    cell.driver.zero_force()
    with pytest.raises(NotReadyError, match="nothing is paused"):
        cell.driver.resume()
    cell.emulator.order(Fault("biased_force", value=-6.0))
    until(lambda: cell.driver.snapshot().force > 5.5)
    with pytest.raises(NotReadyError, match="arm/resume to say so"):
        in_contact(cell)
    cell.driver.resume()
    in_contact(cell)
    assert cell.driver.snapshot().force < 4.0
    leave(cell)


def test_who_follows_the_arm_is_left_only_where_the_way_is_known_to_be_free(cell):
    """Pressed again while it still leaves, with somebody close behind: it stands."""
    in_contact(cell)
    cell.emulator.order(Fault("biased_force", value=-12.0, duration=0.1))
    until(lambda: cell.state() is State.RETRACTING and cell.gap() > 0.02)
    head = cell.driver.loop.where()
    everywhere = np.stack(np.meshgrid(*[np.linspace(-0.3, 0.3, 31)] * 3), -1).reshape(-1, 3)
    around = everywhere + cell.driver.arm.head(head)[:3, 3] - 0.3 * AXIS
    cell.driver.surroundings.see(around, time.monotonic())
    cell.emulator.order(Fault("biased_force", value=-20.0))
    until(lambda: cell.state() is State.FAULT)
    assert "the body" in cell.driver.snapshot().reason
    until(lambda: np.abs(cell.emulator.trace.data().joint_speeds[-1]).max() < 1e-3)
    assert cell.gap() < 0.09


@pytest.mark.parametrize("gives_up", [False, True])
def test_what_waits_in_front_of_a_controller_that_stood_still_is_not_obeyed_later(gives_up):
    """Frames that went out before the silence was noticed wait in the controller, and a stop behind them."""
    with running(stale_after=0.3, wait_at_most=0.5, deaf_after=0.1, **QUICK) as cell:
        scrubbing(cell, speed=0.08)
        cell.emulator.order(Fault("stalled"))
        until(lambda: cell.state() is State.FAULT)
        if gives_up:
            cell.driver.link.client.reconnect()
        stood = cell.emulator.truth().T_base_head[:3, 3]
        cell.emulator.order(Fault("none"))
        time.sleep(0.5)
        assert np.linalg.norm(cell.emulator.truth().T_base_head[:3, 3] - stood) < 2e-4


def test_a_driver_that_was_held_up_does_not_move_on():
    """The control loop's thread stands still for a while, as all of a process does that is stopped."""
    with running(stale_after=0.3, wait_at_most=0.5) as cell:
        cell.approach()
        for segment in segments(count=6, speed=0.05):
            cell.driver.follow(segment)
        until(lambda: cell.driver.snapshot().distance_along > 0.01)
        with cell.driver.loop.lock:
            time.sleep(0.5)
        until(lambda: cell.state() is State.FAULT)
        assert "stood still" in cell.driver.snapshot().reason
        stood = cell.emulator.truth().joints
        time.sleep(0.3)
        assert np.abs(cell.emulator.truth().joints - stood).max() < 1e-3
