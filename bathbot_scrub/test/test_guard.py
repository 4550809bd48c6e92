"""The force guard: which reading leads to which state and action."""

import numpy as np
import pytest
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.arm.states import QUIET, Action, Alarm, Cause, Reaction, State
from bathbot_scrub.rm65.force.wrench_filter import Trend
from bathbot_scrub.rm65.guard.force_checks import Reading
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from hypothesis import given
from hypothesis import strategies as st

LIMITS = shipped_force_limits()
TRUNK, FACE = LIMITS.region("Trunk_skin"), LIMITS.region("Face_skin")
forces = st.tuples(*[st.floats(-40.0, 40.0)] * 3).map(np.array)


SILENT = Alarm("silence", Reaction.WAIT, "no state", force=False, joints=False)
DEAD = SILENT._replace(reaction=Reaction.FAULT)
FROZEN = Alarm("frozen_force", Reaction.FAULT, "the sensor is frozen", force=False)
BROKEN = Alarm("joint_error", Reaction.FAULT, "joint 3", joints=False)
UNSTEADY = Alarm("unsteady", Reaction.WAIT, "waits for steady data")
IDLE = Alarm("idle_contact", Reaction.LEAVE, "nothing to do")
STARVED = Alarm("queue_starvation", Reaction.TELL, "waits for segments")
ALARMS = (QUIET, SILENT, DEAD, FROZEN, BROKEN, UNSTEADY, IDLE, STARVED)


def reading(force=(0.0, 0.0, 0.0), torque=(0.0, 0.0, 0.0), sudden=None, rise=0.0, stamp=0.0):
    wrench = np.array([*force, *torque], dtype=float)
    fast = wrench if sudden is None else np.array([0.0, 0.0, -sudden, 0.0, 0.0, 0.0])
    trends = (Trend(5, 0.02, float(np.linalg.norm(wrench[:3])), rise),) if rise else ()
    return Reading(stamp, wrench, wrench, fast, trends, 0.005)


def check(guard, felt, alarm=QUIET, moving=None):
    """Judge a reading; the arm moves, unless said otherwise, in the states in which it goes somewhere."""
    goes = guard.state in (State.APPROACH, State.RETRACTING)
    return guard.check(felt, alarm, goes if moving is None else moving)


def guard_in(state, region=TRUNK):
    guard = ForceGuard(LIMITS)
    guard.vouch("at home")
    if state is not State.FREE:
        guard.begin_approach(region)
    if state in (State.CONTACT, State.RETRACTING):
        guard.begin_seeking()
        assert check(guard, reading((0.0, 0.0, -1.1))) is Action.STOP
        assert check(guard, reading((0.0, 0.0, -1.1))) is Action.GO_ON
    if state is State.RETRACTING:
        guard.begin_retract()
    if state is State.HOLD:
        guard.stop("stopped")
    if state is State.FAULT:
        guard.fault("test")
    assert guard.state is state
    return guard


def test_contact_is_felt_only_on_the_straight_part():
    guard = guard_in(State.APPROACH)
    assert check(guard, reading((0.0, 0.0, -1.5))) is Action.GO_ON
    assert guard.state is State.APPROACH
    guard.begin_seeking()
    assert check(guard, reading((0.0, 0.0, -0.9))) is Action.GO_ON
    assert check(guard, reading((0.0, 0.0, -1.0))) is Action.STOP
    assert guard.state is State.CONTACT
    assert guard.touching


def test_a_path_that_begins_as_the_search_comes_to_rest_does_not_blunt_the_guard():
    """Segments may come before the next reading is judged: the search is over all the same."""
    guard = guard_in(State.APPROACH, FACE)
    guard.begin_seeking()
    assert check(guard, reading((0.0, 0.0, -1.1), stamp=1.0)) is Action.STOP
    guard.rest()
    assert check(guard, reading((0.0, 0.0, -1.8), rise=30.0, stamp=1.1), moving=True) is Action.RETRACT


@given(force=forces)
def test_in_contact_the_arm_leaves_exactly_when_a_limit_is_passed(force):
    guard = guard_in(State.CONTACT)
    over = np.linalg.norm(force) > TRUNK.retract or (np.abs(force) > TRUNK.axis).any()
    action = check(guard, reading(force))
    assert (action is Action.RETRACT) == over
    assert (guard.state is State.RETRACTING) == over
    assert guard.state is State.RETRACTING or guard.reason == ""


@pytest.mark.parametrize(
    ("what", "told"),
    [
        pytest.param({"force": (0.0, 0.0, -10.5)}, "above 10 N", id="resultant"),
        pytest.param({"force": (6.5, 0.0, 0.0)}, "along x above 6 N", id="x"),
        pytest.param({"force": (0.0, -6.5, 0.0)}, "along y above 6 N", id="y"),
        pytest.param({"torque": (0.0, 0.35, 0.0)}, "torque", id="torque"),
        pytest.param({"sudden": 15.5}, "hard limit", id="hard"),
        pytest.param({"force": (0.0, 0.0, -2.0), "rise": 26.0}, "rises", id="rise"),
    ],
)
def test_every_limit_acts_and_says_so(what, told):
    guard = guard_in(State.CONTACT)
    assert check(guard, reading(**what)) is Action.RETRACT
    assert told in guard.reason
    assert guard.cause is Cause.FORCE


def test_the_rise_that_ends_a_search_is_our_own():
    guard = guard_in(State.APPROACH)
    guard.begin_seeking()
    check(guard, reading((0.0, 0.0, -1.2), rise=30.0))
    assert check(guard, reading((0.0, 0.0, -1.5), rise=30.0), moving=True) is Action.GO_ON
    check(guard, reading((0.0, 0.0, -1.5)))
    assert check(guard, reading((0.0, 0.0, -1.5), rise=35.0)) is Action.RETRACT


@pytest.mark.parametrize(("force", "rise"), [(3.4, 24.0), (1.0, 35.0)], ids=["slowly", "with give left"])
def test_a_rise_that_the_bristles_take_up_is_let_be(force, rise):
    guard = guard_in(State.CONTACT)
    assert check(guard, reading((0.0, 0.0, -force), rise=rise)) is Action.GO_ON


def test_the_region_decides():
    assert check(guard_in(State.CONTACT, FACE), reading((0.0, 0.0, -4.5))) is Action.RETRACT
    assert check(guard_in(State.CONTACT, TRUNK), reading((0.0, 0.0, -4.5))) is Action.GO_ON


@pytest.mark.parametrize(("sudden", "after"), [(11.0, State.HOLD), (16.0, State.FAULT)])
def test_after_a_forced_retract_it_holds_and_above_the_hard_limit_it_faults(sudden, after):
    guard = guard_in(State.CONTACT)
    check(guard, reading((0.0, 0.0, -11.0), sudden=sudden))
    guard.arrived("retracted")
    assert guard.state is after
    assert "retracted: force" in guard.reason
    assert not guard.touching


def test_the_hard_limit_counts_while_leaving_too():
    guard = guard_in(State.CONTACT)
    check(guard, reading((0.0, 0.0, -11.0)))
    assert check(guard, reading((0.0, 0.0, -20.0))) is Action.GO_ON
    guard.arrived("retracted")
    assert guard.state is State.FAULT


def test_an_asked_retract_ends_free():
    guard = guard_in(State.RETRACTING)
    guard.arrived("retracted")
    assert (guard.state, guard.reason, guard.touching) == (State.FREE, "retracted", False)


@pytest.mark.parametrize("needs_consent", [True, False])
def test_after_a_forced_retract_someone_must_allow_the_next_motion(needs_consent):
    guard = ForceGuard(LIMITS, needs_consent)
    guard.vouch("at home")
    guard.begin_approach(TRUNK)
    guard.begin_seeking()
    check(guard, reading((0.0, 0.0, -11.0)))
    guard.arrived("retracted")
    assert guard.state is State.HOLD
    if needs_consent:
        with pytest.raises(NotReadyError, match="arm/resume"):
            guard.begin_approach(TRUNK)
        assert guard.resume() is False
        assert guard.state is State.FREE
    guard.begin_approach(TRUNK)


def test_the_answer_is_counted_from_the_first_sample_over_the_limit():
    guard = guard_in(State.CONTACT)
    check(guard, reading((0.0, 0.0, -11.0), stamp=1.0)._replace(wrench=np.zeros(6), sudden=np.zeros(6)))
    assert guard.over_since == 1.0
    assert check(guard, reading((0.0, 0.0, -11.0), stamp=1.005)) is Action.RETRACT
    assert guard.over_since == 1.0
    check(guard, reading(stamp=2.0))
    assert guard.over_since is None


def test_something_met_in_free_air_sends_it_back_and_a_push_at_rest_does_not():
    guard = guard_in(State.APPROACH)
    assert check(guard, reading((0.0, 2.9, 0.0))) is Action.GO_ON
    assert check(guard, reading((0.0, 3.1, 0.0))) is Action.RETRACT
    assert "in free air" in guard.reason
    idle = guard_in(State.FREE)
    assert check(idle, reading((0.0, 12.0, 0.0))) is Action.GO_ON
    assert idle.state is State.FREE


def test_nothing_felt_ends_in_hold_that_must_retract_first():
    guard = guard_in(State.APPROACH)
    guard.begin_seeking()
    guard.arrived("")
    assert guard.state is State.HOLD
    assert guard.cause is Cause.NO_CONTACT
    with pytest.raises(NotReadyError, match="arm/retract first"):
        guard.begin_approach(TRUNK)


@pytest.mark.parametrize("state", [State.APPROACH, State.CONTACT, State.RETRACTING, State.FAULT])
def test_an_approach_begins_only_from_free_or_hold(state):
    with pytest.raises(NotReadyError, match=state.name):
        guard_in(state).begin_approach(TRUNK)


def test_pause_and_resume_return_to_what_was_done():
    guard = guard_in(State.CONTACT)
    guard.pause()
    assert (guard.state, guard.paused) == (State.HOLD, True)
    assert guard.resume()
    assert guard.state is State.CONTACT
    with pytest.raises(NotReadyError, match="nothing is paused"):
        guard.resume()


def test_a_paused_arm_on_the_skin_still_leaves():
    guard = guard_in(State.CONTACT)
    guard.pause()
    assert check(guard, reading((0.0, 0.0, -11.0))) is Action.RETRACT
    assert not guard.paused


def test_a_paused_search_goes_on_searching():
    guard = guard_in(State.APPROACH)
    guard.begin_seeking()
    guard.pause()
    guard.resume()
    assert check(guard, reading((0.0, 0.0, -1.2))) is Action.STOP
    assert guard.state is State.CONTACT


@pytest.mark.parametrize("state", [State.FREE, State.HOLD], ids=lambda state: state.name)
def test_a_person_who_follows_the_arm_is_left_again(state):
    guard = guard_in(State.CONTACT)
    if state is State.FREE:
        guard.begin_retract()
    else:
        check(guard, reading((0.0, 0.0, -11.0)))
    check(guard, reading())
    guard.arrived("retracted")
    assert guard.state is state
    assert check(guard, reading((0.0, 0.0, -1.5), rise=40.0)) is Action.RETRACT
    assert check(guard, reading((0.0, 0.0, -9.0))) is Action.GO_ON
    assert check(guard, reading()) is Action.GO_ON
    assert check(guard, reading((0.0, 0.0, -11.0))) is Action.RETRACT


@pytest.mark.parametrize("told", ["at once", "later"])
def test_a_broken_sensor_is_left_once(told):
    guard = guard_in(State.CONTACT)
    broken = Alarm("saturated_force", Reaction.FAULT, "at the end of its range")
    first = broken if told == "at once" else QUIET
    assert check(guard, reading((0.0, 0.0, -200.0)), first) is Action.RETRACT
    assert check(guard, reading((0.0, 0.0, -200.0)), broken) is Action.GO_ON
    guard.arrived("retracted")
    assert guard.state is State.FAULT
    assert check(guard, reading((0.0, 0.0, -200.0)), broken) is Action.GO_ON
    assert check(guard, reading((0.0, 0.0, -50.0))) is Action.GO_ON  # the filter's memory of it
