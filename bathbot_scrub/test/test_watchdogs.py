"""The watchdogs: which signals lead to which alarm, and for how long."""

import dataclasses
import math

import numpy as np
import pytest
from bathbot_scrub.arm.states import QUIET, Alarm, Reaction
from bathbot_scrub.rm65.controller.error_codes import in_words
from bathbot_scrub.rm65.guard.following_error import NO_LAG
from bathbot_scrub.rm65.guard.signal_health import Activity, Connected, Signals
from bathbot_scrub.rm65.guard.watchdogs import UNSTEADY, WATCHDOGS, Watchdogs, gravest
from bathbot_scrub.rm65.settings import DriverSettings
from hypothesis import given
from hypothesis import strategies as st

SETTINGS = DriverSettings()
CONNECTED, BUSY = Connected(True, "", 0.0), Activity(False, 0.0, False)
GOOD = Signals(0.003, 0, 0, True, 0, np.zeros(6), (), (), NO_LAG, CONNECTED, BUSY)
PRESSED = np.array([0.0, 0.0, -199.0, 0.0, 0.0, 0.0])
BAD = {
    "silence": {"age": 0.06},
    "unreadable": {"age": 0.06, "refused": 12},
    "late_samples": {"late": 12},
    "excess_samples": {"excess": True},
    "leaping_joints": {"leap": 3},
    "no_force": {"finite": False},
    "frozen_force": {"repeats": 12},
    "saturated_force": {"wrench": PRESSED},
    "force_sensor_error": {"errors": (0x2003,)},
    "controller_error": {"errors": (0x100D,)},
    "joint_error": {"joint_errors": (0, 0, 0x800, 0, 0, 0)},
    "following_error": {"lag": NO_LAG._replace(beyond=0.02, lasts=4)},
    "not_following": {"lag": NO_LAG._replace(told=0.002, went=0.0001)},
    "tcp_lost": {"tcp": CONNECTED._replace(connected=False)},
    "tcp_deaf": {"tcp": CONNECTED._replace(unanswered=0.11)},
    "no_power": {"tcp": CONNECTED._replace(powered=False)},
    "planner_silence": {"activity": Activity(True, 11.0, True)},
    "idle_contact": {"activity": Activity(False, 11.0, False)},
    "queue_starvation": {"activity": Activity(True, 1.0, True)},
}


def judge(dogs=None, now=0.0, **signals):
    return (dogs or Watchdogs(SETTINGS)).judge(GOOD._replace(**signals), now)


def test_good_signs_raise_nothing():
    assert judge() == ()
    assert gravest(()) is QUIET


@pytest.mark.parametrize("name", ["following_error", "not_following"])
def test_datagrams_that_repeat_themselves_tell_nothing_of_the_joints(name):
    assert name in {alarm.name for alarm in judge(repeats=2, **BAD[name])}
    assert name not in {alarm.name for alarm in judge(repeats=3, **BAD[name])}


@pytest.mark.parametrize("dog", WATCHDOGS, ids=lambda dog: dog.name)
def test_every_watchdog_barks_with_its_reaction_and_says_what_is_wrong(dog):
    alarms = {alarm.name: alarm for alarm in judge(**BAD[dog.name])}
    alarm = alarms[dog.name]
    assert (alarm.reaction, alarm.force, alarm.joints) == (dog.reaction, dog.force, dog.joints)
    assert alarm.message
    assert "\n" not in alarm.message
    assert gravest(list(alarms.values())).reaction is max(a.reaction for a in alarms.values())


def test_what_each_watchdog_leaves_to_be_trusted():
    """Written out here, for it decides who is left, who is stood still for, and who may call arm/retract."""
    doubts_force = {"silence", "unreadable", "no_force", "frozen_force", "force_sensor_error"}
    doubts_force |= {"excess_samples", "leaping_joints"}
    doubts_joints = {"silence", "unreadable", "controller_error", "joint_error", "following_error"}
    doubts_joints |= {"not_following", "tcp_lost", "tcp_deaf", "no_power", "excess_samples", "leaping_joints"}
    assert {dog.name for dog in WATCHDOGS if not dog.force} == doubts_force
    assert {dog.name for dog in WATCHDOGS if not dog.joints} == doubts_joints


@pytest.mark.parametrize("dog", WATCHDOGS, ids=lambda dog: dog.name)
def test_every_deadline_is_a_parameter_that_acts(dog):
    if dog.deadline not in {field.name for field in dataclasses.fields(DriverSettings)}:
        assert dog.deadline == "at once"
        return
    value = getattr(SETTINGS, dog.deadline)
    longer = {dog.deadline: 2 * value, "stale_after": 1.0}
    patient = Watchdogs(dataclasses.replace(SETTINGS, **longer))
    assert dog.name in {alarm.name for alarm in judge(**BAD[dog.name])}
    assert dog.name not in {alarm.name for alarm in judge(patient, **BAD[dog.name])}


@pytest.mark.parametrize("signals", [{"age": math.inf}, {"age": math.nan}], ids=["never", "not a number"])
def test_an_age_that_means_nothing_is_silence(signals):
    assert [alarm.name for alarm in judge(**signals)] == ["silence"]


@pytest.mark.parametrize("name", ["silence", "unreadable", "late_samples", "no_force", "tcp_deaf"])
def test_what_makes_the_arm_wait_becomes_a_fault_when_it_lasts(name):
    dogs = Watchdogs(SETTINGS)
    for now in np.arange(0.0, 0.25, 0.01):
        assert gravest(judge(dogs, now, **BAD[name])).reaction is Reaction.WAIT
    assert gravest(judge(dogs, 0.26, **BAD[name])).reaction is Reaction.FAULT


def test_after_a_gap_data_must_be_steady_before_all_is_quiet():
    dogs = Watchdogs(SETTINGS)
    judge(dogs, 0.0, age=0.06)
    (waits,) = judge(dogs, 0.01)
    assert (waits.name, waits.reaction, waits.force, waits.joints) == (UNSTEADY, Reaction.WAIT, True, True)
    assert judge(dogs, 0.29)
    assert judge(dogs, 0.31) == ()


def test_data_that_come_and_go_end_in_a_fault():
    dogs, reactions = Watchdogs(SETTINGS), []
    for index in range(260):
        signals = {"age": 0.06} if index % 20 < 10 else {}
        reactions.append(gravest(judge(dogs, 0.01 * index, **signals)).reaction)
    assert reactions[:200] == [Reaction.WAIT] * 200
    assert reactions[210] is Reaction.FAULT


def test_the_trust_is_what_all_alarms_leave():
    frozen = Alarm("frozen_force", Reaction.FAULT, "frozen", force=False)
    deaf = Alarm("tcp_deaf", Reaction.WAIT, "deaf", joints=False)
    assert gravest([deaf, frozen]) == frozen._replace(joints=False)


@given(system=st.lists(st.integers(-1, 0xFFFF)), joints=st.lists(st.integers(0, 0xFFFF), max_size=6))
def test_every_error_code_has_words_in_one_line(system, joints):
    words = in_words(system, joints)
    assert bool(words) == any([*system, *joints])
    assert "\n" not in words


def test_codes_in_words():
    assert "COLLISION".lower() in in_words([0x100D], [])
    assert in_words([], [0, 0, 0x840]) == "joint 3, error 0x0840: overcurrent, following error"
    assert "frames lost" in in_words([], [0xF000])
    assert "not in the list" in in_words([0x7777], [])
