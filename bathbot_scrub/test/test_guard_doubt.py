"""The force guard when the watchdogs doubt what is measured."""

import pytest
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.states import Action, Alarm, Cause, Reaction, State
from test_guard import (
    ALARMS,
    BROKEN,
    DEAD,
    FROZEN,
    IDLE,
    SILENT,
    STARVED,
    TRUNK,
    UNSTEADY,
    check,
    guard_in,
    reading,
)


@pytest.mark.parametrize("state", [State.APPROACH, State.CONTACT, State.RETRACTING])
@pytest.mark.parametrize("alarm", [DEAD, BROKEN], ids=lambda alarm: alarm.name)
def test_doubtful_joints_stop_whatever_moves_or_touches(state, alarm):
    guard = guard_in(state)
    assert check(guard, reading(), alarm) is Action.STOP
    assert (guard.state, guard.reason, guard.cause) == (State.FAULT, alarm.message, Cause.DATA)


@pytest.mark.parametrize("state", [State.APPROACH, State.CONTACT])
def test_a_doubtful_force_stops_the_arm_and_lets_it_leave_only_when_asked(state):
    guard = guard_in(state)
    assert check(guard, reading((0.0, 0.0, -30.0)), FROZEN) is Action.STOP
    assert guard.state is State.FAULT
    guard.begin_retract(FROZEN)
    assert check(guard, reading((0.0, 0.0, -30.0)), FROZEN) is Action.GO_ON
    guard.arrived("retracted")
    assert (guard.state, guard.touching) == (State.FAULT, False)


def test_a_force_that_fails_while_leaving_does_not_hold_the_arm_on_the_skin():
    guard = guard_in(State.RETRACTING)
    assert check(guard, reading(), FROZEN) is Action.GO_ON
    guard.arrived("retracted")
    assert guard.state is State.FAULT
    assert "frozen" in guard.reason


@pytest.mark.parametrize("alarm", [DEAD, BROKEN], ids=lambda alarm: alarm.name)
def test_nobody_makes_it_leave_on_doubtful_joints(alarm):
    guard = guard_in(State.CONTACT)
    check(guard, reading(), alarm)
    with pytest.raises(NotReadyError, match="cannot retract"):
        guard.begin_retract(alarm)
    assert guard.state is State.FAULT


def test_an_idle_arm_waits_for_data_without_fault():
    guard = guard_in(State.FREE)
    for alarm in ALARMS:
        assert check(guard, reading(), alarm) is Action.GO_ON
    assert guard.state is State.FREE


@pytest.mark.parametrize("state", [State.APPROACH, State.CONTACT, State.RETRACTING])
def test_silence_makes_it_stand_and_steady_data_let_it_go_on(state):
    guard = guard_in(state)
    assert check(guard, reading(), SILENT) is Action.STOP
    assert check(guard, reading(), SILENT) is Action.GO_ON
    assert (guard.state, guard.waiting) == (state, SILENT.message)
    leaving = state is State.RETRACTING  # which needs no steady force
    assert check(guard, reading(), UNSTEADY) is (Action.RESUME if leaving else Action.GO_ON)
    assert check(guard, reading()) is (Action.GO_ON if leaving else Action.RESUME)
    assert (guard.state, guard.waiting) == (state, "")


def test_while_it_waits_the_guard_is_armed_the_moment_force_is_back():
    guard = guard_in(State.CONTACT)
    check(guard, reading(), SILENT)
    assert check(guard, reading((0.0, 0.0, -11.0)), SILENT) is Action.GO_ON
    assert check(guard, reading((0.0, 0.0, -11.0)), UNSTEADY) is Action.RETRACT


def test_silence_that_lasts_is_a_fault_and_a_wait_that_is_given_up_does_not_go_on():
    guard = guard_in(State.APPROACH)
    check(guard, reading(), SILENT)
    assert check(guard, reading(), DEAD) is Action.STOP
    assert check(guard, reading()) is Action.GO_ON
    assert (guard.state, guard.waiting) == (State.FAULT, "")
    guard = guard_in(State.CONTACT)
    check(guard, reading(), SILENT)
    guard.stop("stopped")
    check(guard, reading(), SILENT)
    assert guard.state is State.HOLD


def test_nothing_to_do_on_the_skin_makes_it_leave_and_needs_no_consent():
    guard = guard_in(State.CONTACT)
    assert check(guard, reading(), STARVED) is Action.GO_ON
    assert check(guard, reading(), IDLE) is Action.RETRACT
    guard.arrived("retracted")
    assert (guard.state, guard.cause) == (State.HOLD, Cause.IDLE)
    guard.begin_approach(TRUNK)


@pytest.mark.parametrize("alarm", [SILENT, DEAD, FROZEN, BROKEN], ids=lambda alarm: alarm.name)
def test_a_fault_is_left_only_with_good_data_and_by_asking(alarm):
    guard = guard_in(State.FAULT)
    with pytest.raises(NotReadyError, match="cannot resume"):
        guard.resume(alarm)
    assert guard.resume() is False
    assert guard.state is State.HOLD


def test_a_faulted_arm_on_the_skin_leaves_when_pressed_by_good_data():
    guard = guard_in(State.CONTACT)
    guard.fault("test")
    for alarm in (SILENT, DEAD, FROZEN, BROKEN):
        assert check(guard, reading((0.0, 0.0, -11.0)), alarm) is Action.GO_ON
    assert check(guard, reading((0.0, 0.0, -11.0)), UNSTEADY) is Action.RETRACT
    guard.arrived("retracted")
    assert guard.state is State.FAULT


def test_a_force_at_the_end_of_the_range_is_left_and_needs_a_person():
    guard = guard_in(State.CONTACT)
    saturated = Alarm("saturated_force", Reaction.FAULT, "at the end of its range")
    assert check(guard, reading((0.0, 0.0, -199.0)), saturated) is Action.RETRACT
    guard.arrived("retracted")
    assert guard.state is State.FAULT
    with pytest.raises(NotReadyError, match="end of its range"):
        guard.resume(saturated)
