"""Whose states are believed, and how many of them: time is an argument."""

import numpy as np
import pytest
from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.controller.push_source import LEARN, PushRate, PushSource
from bathbot_scrub.rm65.controller.state_push import ArmSample
from bathbot_scrub.rm65.guard.signal_health import Activity, Connected, SignalHealth
from hypothesis import given
from hypothesis import strategies as st

ARM, FORGER, STRANGER = ("10.0.0.2", 40000), ("10.0.0.2", 40001), ("10.0.0.3", 40000)
CYCLE = 0.005


def expecting():
    source = PushSource()
    source.expect(ARM[0])
    return source


def hear(source, *senders, until=2.0 * LEARN):
    """Who of these is believed, all of them sending every 5 ms from now on."""
    count = round(until / CYCLE)
    return {sender for step in range(count) for sender in senders if source.believes(sender, step * CYCLE)}


def test_nobody_is_believed_before_the_push_was_ordered():
    assert hear(PushSource(), ARM, STRANGER) == set()


def test_the_only_sender_at_the_address_is_believed_after_a_while_and_no_other_any_more():
    source = expecting()
    assert hear(source, ARM, STRANGER, until=LEARN) == set()
    assert hear(source, ARM, STRANGER) == {ARM}
    assert hear(source, FORGER, STRANGER) == set()
    assert source.trouble == ""


def test_where_two_ports_speak_neither_is_believed_until_one_has_ended():
    source = expecting()
    assert hear(source, FORGER, ARM) == set()
    assert "40000 and 40001" in source.trouble
    assert hear(source, ARM) == set()  # not by itself
    source.expect(ARM[0])
    assert source.trouble == ""
    assert hear(source, ARM) == {ARM}


def test_a_controller_that_starts_again_is_known_by_its_new_port_after_a_new_set_up_only():
    source = expecting()
    hear(source, ARM)
    assert hear(source, FORGER) == set()
    source.expect(ARM[0])
    assert hear(source, FORGER) == {FORGER}


@given(st.lists(st.floats(-0.002, 0.002), min_size=400, max_size=400), st.floats(0.0, 0.45))
def test_what_was_ordered_is_never_too_much_even_when_it_waited(jitter, held_up):
    rate = PushRate(1.0 / CYCLE)
    for step, uneven in enumerate(jitter):
        due = step * CYCLE + uneven
        assert not rate.exceeded(max(due, held_up))


@pytest.mark.parametrize("times", [1.5, 2.0, 10.0, 200.0])
def test_more_than_ordered_is_noticed(times):
    rate = PushRate(1.0 / CYCLE)
    stamps = np.arange(0.0, 2.0, CYCLE / times)
    exceeded = [stamp for stamp in stamps if rate.exceeded(stamp)]
    extra = (times - 1.06) / CYCLE  # datagrams per second beyond what is tolerated
    assert exceeded[0] < 101.0 / extra + 0.01


def told(health, now):
    return health.signals(now, Connected(True, "", 0.0), Activity(False, 0.0, False))


def sample(stamp, joints):
    return ArmSample(stamp, joints, np.zeros(6), np.full(6, stamp), np.eye(4), (), (), "")


@given(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6), st.integers(1, 20))
def test_joints_that_turn_as_fast_as_they_can_do_not_leap_however_they_arrive(share, together):
    health = SignalHealth(0.005, 0.01)
    for step in range(40):
        arrival = (step // together + 1) * together * CYCLE  # so many at once
        joints = np.array(share) * RM65_LIMITS.speed * CYCLE * step
        health.sample(sample(arrival + 1e-4 * (step % together), joints))
        assert told(health, arrival).leap == 0


@pytest.mark.parametrize("joint", range(6))
def test_joints_in_two_places_leap(joint):
    health, there = SignalHealth(0.005, 0.01), np.zeros(6)
    there[joint] = 0.1
    for step in range(4):
        health.sample(sample(step * CYCLE, there if step % 2 else np.zeros(6)))
    assert told(health, 4 * CYCLE).leap == joint + 1


def test_an_excess_is_told_for_a_while():
    health = SignalHealth(0.005, 0.01)
    health.sample(sample(1.0, np.zeros(6)))
    assert not told(health, 1.0).excess
    health.exceed(1.0)
    assert told(health, 1.01).excess
    assert not told(health, 2.0).excess
