"""Every condition of the guard that any order of events, readings and alarms can lead to.

Breadth first from the beginning, by putting a condition into a guard and letting one thing happen. What does
not decide is left out of a condition: wording, and when exactly something was.
"""

import time
from collections import deque
from typing import NamedTuple

import numpy as np
import pytest
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.arm.states import QUIET, TRANSITIONS, Action, Alarm, Cause, Reaction, State
from bathbot_scrub.rm65.force.wrench_filter import Trend
from bathbot_scrub.rm65.guard.condition import Condition
from bathbot_scrub.rm65.guard.force_checks import Reading
from bathbot_scrub.rm65.guard.force_guard import ForceGuard

LIMITS = shipped_force_limits()
TRUNK = LIMITS.region("Trunk_skin")
WAYS = {(way.before, way.after) for way in TRANSITIONS}
STANDS, MOVES = False, True


def pressed(force, rise=0.0):
    wrench = np.array([0.0, 0.0, -force, 0.0, 0.0, 0.0])
    return Reading(0.0, wrench, wrench, wrench, (Trend(5, 0.02, force, rise),), 0.005)


READINGS = {
    "nothing": pressed(0.1),
    "touch": pressed(1.5),
    "excess": pressed(11.0),
    "hard": pressed(16.0),
    "surge": pressed(2.0, rise=100.0),
    "not a number": pressed(np.nan),
}
ALARMS = {
    "quiet": QUIET,
    "wait": Alarm("unsteady", Reaction.WAIT, "unsteady"),
    "wait, force": Alarm("no_force", Reaction.WAIT, "no force", force=False),
    "wait, both": Alarm("silence", Reaction.WAIT, "silence", force=False, joints=False),
    "leave": Alarm("idle_contact", Reaction.LEAVE, "idle"),
    "leave, both": Alarm("idle_contact", Reaction.LEAVE, "idle, and silence", force=False, joints=False),
    "fault": Alarm("saturated_force", Reaction.FAULT, "saturated"),
    "fault, force": Alarm("frozen_force", Reaction.FAULT, "frozen", force=False),
    "fault, joints": Alarm("joint_error", Reaction.FAULT, "joint", joints=False),
}
CHECKS = [(reading, alarm, moving) for reading in READINGS for alarm in ALARMS for moving in (STANDS, MOVES)]
PLAIN = {
    "vouch": lambda guard: guard.vouch("free"),
    "approach": lambda guard: guard.begin_approach(TRUNK),
    "seek": ForceGuard.begin_seeking,
    "path": lambda guard: guard.begin_path(TRUNK),
    "arrived": lambda guard: guard.arrived("there"),
    "rest": ForceGuard.rest,
    "cornered": ForceGuard.could_not_leave,
    "stop": lambda guard: guard.stop("stopped"),
    "pause": ForceGuard.pause,
    "fault": lambda guard: guard.fault("a bug"),
}
ASKED = {"resume": ForceGuard.resume, "retract": ForceGuard.begin_retract}


class Step(NamedTuple):
    """One thing that happened to a guard; a reading that was judged has an action."""

    before: Condition
    event: str
    reading: str
    alarm: str
    moving: bool
    told: Action | bool | None  # what the guard gave; None: nothing, or refused
    refused: bool
    after: Condition

    @property
    def good(self):
        """Whether force and joints could be trusted."""
        alarm = ALARMS[self.alarm]
        return alarm.force and alarm.joints and self.reading != "not a number"

    @property
    def near(self):
        return self.before.touching or self.before.facing


def essence(condition):
    """A condition without wording and times; how fast a rise must be is judged elsewhere."""
    return condition._replace(
        reason="",
        cause=Cause.START if condition.cause is Cause.START else Cause.NONE,
        waiting="data" if condition.waiting else "",
        consent="ask" if condition.consent else "",
        settled=False,
        doubted=-np.inf,
        over_since=None,
    )


def happen(condition, event, reading="", alarm="quiet", moving=STANDS):
    """What one thing does to a condition."""
    guard, told, refused = ForceGuard(LIMITS, condition=condition), None, False
    try:
        if event == "check":
            told = guard.check(READINGS[reading], ALARMS[alarm], moving)
        elif event in ASKED:
            told = ASKED[event](guard, ALARMS[alarm])
        else:
            told = PLAIN[event](guard)
    except NotReadyError:
        refused = True
    return Step(condition, event, reading, alarm, moving, told, refused, essence(guard.condition))


def all_steps(condition):
    yield from (happen(condition, "check", *check) for check in CHECKS)
    yield from (happen(condition, event) for event in PLAIN)
    yield from (happen(condition, event, alarm=alarm) for event in ASKED for alarm in ALARMS)


@pytest.fixture(scope="module")
def steps():
    """Every step from every condition that can be reached."""
    begun = time.monotonic()
    first = essence(ForceGuard(LIMITS).condition)
    found, open_, taken = {first}, deque([first]), []
    while open_:
        for step in all_steps(open_.popleft()):
            taken.append(step)
            if step.after not in found:
                found.add(step.after)
                open_.append(step.after)
    print(f"{len(found)} conditions, {len(taken)} steps, {time.monotonic() - begun:.1f} s")
    return taken


def checks(steps):
    return [step for step in steps if step.event == "check"]


def test_only_the_ways_of_the_table_are_taken_and_each_of_them_is(steps):
    """The table is exact: the driver can go every way that it shows, and no other."""
    gone = {(step.before.state, step.after.state) for step in steps}
    assert {way for way in gone if way[0] is not way[1]} == WAYS


def test_excess_by_good_data_ends_in_leaving(steps):
    for step in checks(steps):
        excess = step.reading in ("excess", "hard") or (step.reading == "surge" and step.near)
        stands_off = not step.near and (step.moving is STANDS or step.before.state is State.FAULT)
        cornered = step.before.state is State.FAULT and step.before.cornered
        if excess and step.good and not stands_off and not cornered:
            assert step.after.state is State.RETRACTING, step
            assert step.told is Action.RETRACT or step.before.state is State.RETRACTING, step


def test_a_fault_is_where_the_hard_limit_ends(steps):
    for step in checks(steps):
        if step.reading == "hard" and step.after.state is State.RETRACTING and step.good:
            assert step.after.after_retract is State.FAULT, step


def test_doubtful_joints_start_no_motion(steps):
    for step in steps:
        if not ALARMS[step.alarm].joints:
            assert step.told not in (Action.RETRACT, Action.RESUME, True), step
            started = step.event == "retract" and not step.refused
            assert not started or step.after.waiting or step.before.state is State.RETRACTING, step


def test_doubtful_force_starts_no_motion_but_that_of_who_leaves(steps):
    for step in checks(steps):
        if not ALARMS[step.alarm].force or step.reading == "not a number":
            assert step.told is not Action.RETRACT, step
            assert step.told is not Action.RESUME or step.before.state is State.RETRACTING, step


def test_touching_is_forgotten_only_at_the_end_of_a_retract(steps):
    for step in steps:
        if step.before.touching and not step.after.touching:
            assert (step.event, step.before.state) == ("arrived", State.RETRACTING), step


def test_nothing_that_may_touch_counts_as_free(steps):
    for step in steps:
        assert not (step.after.state is State.FREE and step.after.touching), step


def test_skin_is_felt_whenever_the_head_may_touch_on_its_way(steps):
    """What waits stands, and feels it before it goes on."""
    for step in checks(steps):
        if not (step.before.state is State.APPROACH and step.before.touching and step.reading == "touch"):
            continue
        if step.good and ALARMS[step.alarm].reaction < Reaction.LEAVE and step.alarm != "wait":
            assert (step.after.state, step.told) == (State.CONTACT, Action.STOP), step
        assert step.told is not Action.RESUME, step


def test_who_could_not_be_left_is_not_tried_again_as_long_as_he_presses(steps):
    for step in checks(steps):
        if step.before.state is State.FAULT and step.before.cornered and step.reading in ("excess", "hard"):
            assert (step.told, step.after.state) == (Action.GO_ON, State.FAULT), step


def test_contact_is_made_where_the_head_may_touch_by_a_force_that_can_be_trusted(steps):
    for step in steps:
        assert step.after.touching or step.after.state is not State.CONTACT, step
    for step in checks(steps):
        if step.after.state is State.CONTACT and step.before.state is not State.CONTACT:
            assert step.good, step


def test_a_search_in_whose_pause_skin_was_felt_does_not_go_on(steps):
    for step in steps:
        if step.event == "resume" and step.told is True and step.after.touching:
            assert step.after.state is State.CONTACT or not step.before.felt, step


def test_what_is_felt_is_known_in_every_state(steps):
    for step in checks(steps):
        if step.good and step.reading == "touch" and step.near:
            assert step.after.felt, step
        if step.good and step.reading in ("excess", "hard"):
            assert step.after.felt, step
        if not step.good and step.event == "check" and step.after.felt is not step.before.felt:
            assert ALARMS[step.alarm].force, step
            assert step.reading != "not a number", step


def test_who_is_touched_for_long_is_left_in_every_state_or_a_person_must_look(steps):
    for step in checks(steps):
        idle = step.alarm == "leave" and step.moving is STANDS and step.good
        if idle and step.near and step.reading == "touch" and not step.before.cornered:
            assert (step.after.state, step.told) == (State.RETRACTING, Action.RETRACT), step
        if idle and not step.near and step.reading == "excess":
            asks = step.after.state is State.HOLD and step.after.consent
            assert asks or step.before.state in (State.FAULT, State.RETRACTING), step


def test_a_standing_arm_moves_for_a_reason_only(steps):
    for step in checks(steps):
        if step.told is Action.RETRACT:
            forced = step.reading in ("excess", "hard", "surge")
            asked = step.near or step.before.state is State.RETRACTING
            assert forced or (step.alarm == "leave" and asked and step.moving is STANDS), step
        if step.told is Action.RESUME:
            assert step.before.waiting, step
            assert step.before.paused_from is None, step
            assert step.after.state in (State.APPROACH, State.CONTACT, State.RETRACTING), step


def test_a_fault_ends_only_when_someone_resumes(steps):
    for step in steps:
        if step.before.state is State.FAULT and step.after.state is not State.FAULT:
            leaves = step.after.state is State.RETRACTING and step.after.after_retract is State.FAULT
            assert leaves or step.event == "resume", step
        if step.before.after_retract is State.FAULT and step.before.state is State.RETRACTING:
            assert step.after.state in (State.FAULT, State.RETRACTING), step


def test_consent_that_is_wanted_is_given_by_a_person_only(steps):
    for step in steps:
        if step.before.consent and not step.after.consent:
            assert step.event in ("resume", "vouch"), step
        if step.event == "approach" and not step.refused:
            assert not step.before.consent, step
            assert not step.before.touching, step
        if step.event == "check" and step.told is Action.RETRACT and step.alarm != "leave":
            assert step.after.consent, step


def test_nobody_vouches_for_an_arm_that_has_done_something(steps):
    for step in steps:
        if step.event == "vouch" and not step.refused:
            assert step.before.cause is Cause.START, step
            assert not step.before.touching, step


def test_what_is_refused_changes_nothing(steps):
    for step in steps:
        assert not step.refused or step.after == step.before, step
