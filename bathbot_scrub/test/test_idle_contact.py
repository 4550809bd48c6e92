"""How long the arm has stood while it touches, in every state; and that something is done about it."""

from itertools import pairwise

import pytest
from bathbot_scrub.arm.states import QUIET, Action, State
from bathbot_scrub.rm65.guard.condition import Condition
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from bathbot_scrub.rm65.guard.watchdogs import IdleContact, Watchdogs, gravest
from bathbot_scrub.rm65.settings import DriverSettings
from test_guard import LIMITS, TRUNK, check, guard_in, reading
from test_watchdogs import GOOD

SETTINGS = DriverSettings()
TOUCH = reading((0.0, 0.0, -1.5))
STATES = [State.FREE, State.APPROACH, State.CONTACT, State.RETRACTING, State.HOLD, State.FAULT]


def lived(guard, felt, seconds, moving=False, on_leave=lambda: None):
    """Let time pass; give the actions with their times [s]. `on_leave` is called when the arm is to leave."""
    idle, dogs, told = IdleContact(), Watchdogs(SETTINGS), []
    for beat in range(round(100 * seconds)):
        now = 0.01 * beat
        activity = idle.judge(guard, moving, False, now)
        alarm = gravest(dogs.judge(GOOD._replace(activity=activity), now))
        action = guard.check(felt, alarm, moving)
        if action is not Action.GO_ON:
            told.append((now, action))
        if action is Action.RETRACT:
            on_leave()
            idle.begin_anew()
    return told


@pytest.mark.parametrize("state", STATES, ids=lambda state: state.name)
def test_a_touch_for_longer_than_the_deadline_is_left_in_every_state(state):
    guard = ForceGuard(LIMITS, condition=Condition(state, TRUNK, facing=True))
    told = lived(guard, TOUCH, 10.5)
    assert [action for _, action in told] == [Action.RETRACT]
    assert told[0][0] == pytest.approx(SETTINGS.leave_after, abs=0.1)
    assert guard.state is State.RETRACTING
    assert "for 10 s" in guard.reason


@pytest.mark.parametrize("state", [State.FREE, State.HOLD], ids=lambda state: state.name)
def test_far_from_the_skin_a_person_must_look_what_it_is(state):
    """Nobody was left here: what presses stands somewhere else, or the sensor has drifted."""
    guard = guard_in(state)
    assert lived(guard, reading((0.0, 0.0, -3.2)), 10.5) == []
    assert guard.state is State.HOLD
    assert "3.2 N are felt where nothing should be" in guard.reason
    assert guard.resume() is False
    assert guard.state is State.FREE
    assert lived(guard, reading((0.0, 0.0, -2.9)), 30.0) == []  # as much as the tool's weight may err
    assert guard.state is State.FREE


def test_nobody_is_left_while_the_arm_moves_or_before_the_deadline():
    guard = guard_in(State.CONTACT)
    assert lived(guard, TOUCH, 60.0, moving=True) == []
    assert lived(guard, TOUCH, 9.9) == []
    assert guard.state is State.CONTACT


def test_on_the_skin_no_force_is_needed_to_count_as_idle():
    guard = guard_in(State.CONTACT)
    check(guard, reading(), moving=False)
    assert [action for _, action in lived(guard, reading(), 10.5)] == [Action.RETRACT]


def test_who_cannot_be_left_is_tried_again_after_as_long():
    guard = guard_in(State.CONTACT)

    def no_way():
        guard.could_not_leave()
        guard.fault("no way straight back")

    told = lived(guard, TOUCH, 31.0, on_leave=no_way)
    assert len(told) == 3
    assert all(later[0] - earlier[0] > 9.0 for earlier, later in pairwise(told))
    assert guard.state is State.FAULT


def test_a_search_that_was_paused_on_the_skin_ends_in_contact_or_off_it():
    guard = guard_in(State.APPROACH)
    guard.begin_seeking()
    guard.pause()
    assert guard.check(TOUCH, QUIET, False) is Action.GO_ON
    assert (guard.state, guard.paused) == (State.HOLD, True)
    assert guard.resume() is False  # it does not go on towards the skin
    assert guard.state is State.CONTACT
    guard.pause()
    assert [action for _, action in lived(guard, TOUCH, 10.5)] == [Action.RETRACT]
