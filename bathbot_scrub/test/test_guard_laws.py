"""Laws of the force guard: what no order of events and readings may lead to."""

import contextlib

import numpy as np
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.states import QUIET, TRANSITIONS, Action, State
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from hypothesis import given, settings
from hypothesis import strategies as st
from test_guard import ALARMS, LIMITS, TRUNK, forces, reading

WAYS = {(way.before, way.after) for way in TRANSITIONS}
EVENTS = ("approach", "seek", "retract", "arrived", "stop", "pause", "resume", "fault", "nothing")
steps = st.lists(
    st.tuples(st.sampled_from(EVENTS), forces, st.booleans(), st.sampled_from(ALARMS)), max_size=30
)


def happen(guard, event, alarm):
    """Let an event happen, refused or not."""
    calls = {
        "approach": lambda: guard.begin_approach(TRUNK),
        "seek": guard.begin_seeking,
        "retract": lambda: guard.begin_retract(alarm),
        "arrived": lambda: guard.arrived("there"),
        "stop": lambda: guard.stop("stopped"),
        "pause": guard.pause,
        "resume": lambda: guard.resume(alarm),
        "fault": lambda: guard.fault("test"),
        "nothing": lambda: None,
    }
    with contextlib.suppress(NotReadyError):
        calls[event]()


def run(steps):
    """Each step: guard, state before the event, before the check, action, force, alarm, whether it moves."""
    guard = ForceGuard(LIMITS)
    guard.vouch("at home")
    for event, force, moving, alarm in steps:
        before = guard.state
        happen(guard, event, alarm)
        between = guard.state
        action = guard.check(reading(force), alarm, moving)
        yield guard, (before, between, guard.state), action, force, alarm, moving


@given(steps)
@settings(max_examples=300)
def test_only_the_ways_of_the_table_are_taken(steps):
    for _, (before, between, after), _, _, _, _ in run(steps):
        assert before is between or (before, between) in WAYS
        assert between is after or (between, after) in WAYS


@given(steps)
@settings(max_examples=300)
def test_excess_force_by_good_data_ends_in_leaving(steps):
    for guard, _, action, force, alarm, _ in run(steps):
        if guard.touching and alarm is QUIET and np.linalg.norm(force) > guard.region.retract:
            assert action is Action.RETRACT or guard.state is State.RETRACTING


@given(steps)
@settings(max_examples=300)
def test_a_fault_moves_only_on_data_that_can_be_trusted(steps):
    for guard, (_, between, after), action, _, alarm, _ in run(steps):
        if between is State.FAULT:
            pressed = (guard.touching or guard.condition.facing) and alarm.force and alarm.joints
            assert action is Action.GO_ON or (action is Action.RETRACT and pressed)
            assert after is State.FAULT or pressed


@given(steps)
@settings(max_examples=300)
def test_doubtful_joints_never_begin_a_motion_and_never_let_one_go_on(steps):
    for guard, _, action, _, alarm, moving in run(steps):
        if not alarm.joints:
            assert action in (Action.STOP, Action.GO_ON)
            if moving:  # stands, waits, or has been told to stop before
                assert guard.waiting or guard.state in (State.FAULT, State.HOLD)


@given(st.lists(st.tuples(forces, st.sampled_from(ALARMS)), max_size=30))
def test_no_readings_alone_move_an_arm_in_fault_off_the_skin(readings):
    guard = ForceGuard(LIMITS)
    guard.fault("test")
    for force, alarm in readings:
        assert guard.check(reading(force), alarm, False) is Action.GO_ON
    assert guard.state is State.FAULT


def test_every_way_of_the_table_can_be_taken():
    found, rng = set(), np.random.default_rng(0)
    nothing, touch = np.zeros(3), np.array([0.0, 0.0, -1.5])
    paused = [("approach", nothing), ("seek", touch), ("pause", touch), ("resume", touch)]
    taken = [[(event, force, False, QUIET) for event, force in paused]]
    for _ in range(300):
        taken.append([])
        for _ in range(25):
            force = rng.normal(0.0, rng.choice([0.7, 4.0]), 3)
            alarm = ALARMS[rng.choice([0, 0, 0, *range(8)])]
            taken[-1].append((rng.choice(EVENTS), force, rng.random() < 0.7, alarm))
    for steps in taken:
        for _, (before, between, after), _, _, _, _ in run(steps):
            found |= {(before, between), (between, after)}
    assert found >= WAYS
