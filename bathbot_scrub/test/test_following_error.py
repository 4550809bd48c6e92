"""Whether joints follow: lag is explained, a joint that jams or stands is found and named."""

import numpy as np
import pytest
from bathbot_scrub.rm65.guard.following_error import FollowingMonitor
from hypothesis import given, settings
from hypothesis import strategies as st

PERIOD, TOLERANCE, STILL = 0.01, 0.01, 0.0015


def lagging(joints, times, lag):
    """Joints, (N, 6), that are `lag` [s] behind."""
    return np.stack([np.interp(times - lag, times, q) for q in joints.T], -1)


@given(
    speeds=st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6),
    lag=st.floats(0.0, 0.07),
    age=st.floats(0.0, 0.05),
)
@settings(max_examples=50)
def test_joints_that_lag_as_a_controller_may_do_follow(speeds, lag, age):
    times = np.arange(0.0, 0.6, PERIOD)
    told = np.outer(np.minimum(times, 0.4), speeds)
    following = FollowingMonitor(TOLERANCE, PERIOD)
    for command, measured in zip(told, lagging(told, times, lag + age), strict=True):
        found = following.command(command, measured, age)
        assert found.lasts == 0
        assert found.told <= STILL


@given(joint=st.integers(0, 5), speed=st.floats(0.1, 1.0))
@settings(max_examples=30)
def test_a_joint_that_jams_is_found_and_named(joint, speed):
    following, found = FollowingMonitor(TOLERANCE, PERIOD), []
    for k in range(60):
        command, measured = np.full(6, speed * PERIOD * k), np.full(6, speed * PERIOD * k)
        measured[joint] = min(measured[joint], speed * PERIOD * 20)
        found.append(following.command(command, measured, 0.0))
    first = next(k for k, lag in enumerate(found) if lag.lasts > 3)
    assert found[first].joint == joint + 1
    # the speed of a joint at rest is also what it may not have reached yet
    assert (first - 20) * PERIOD < 0.13 + (TOLERANCE + speed**2 / 20.0) / speed


@given(joint=st.integers(0, 5), speed=st.floats(0.011, 1.0), age=st.floats(0.0, 0.02))
@settings(max_examples=50)
def test_a_joint_that_stands_is_found_however_slowly_it_turned(joint, speed, age):
    following, found = FollowingMonitor(TOLERANCE, PERIOD), []
    for k in range(80):
        told = np.full(6, speed * PERIOD * k)
        measured = np.full(6, speed * (PERIOD * k - age))
        measured[joint] = min(measured[joint], speed * PERIOD * 40)
        lag = following.command(told, measured, age)
        found.append(max(lag.told - STILL, 0.0) and lag.still)
    first = next(k for k, number in enumerate(found) if number)
    assert set(found[first:]) == {joint + 1}
    assert (first - 40) * PERIOD <= 0.16 + age


@given(turning=st.integers(15, 45), speed=st.floats(0.02, 0.5), lag=st.floats(0.0, 0.07))
@settings(max_examples=50)
def test_a_joint_that_turns_back_or_ends_its_way_does_not_stand_in_vain(turning, speed, lag):
    times = np.arange(0.0, 0.8, PERIOD)
    back = np.minimum(times, 2 * turning * PERIOD - times)
    ended = np.minimum(times, turning * PERIOD)
    told = np.stack([speed * back, speed * ended, 0 * times, -speed * back, -speed * ended, 0 * times], -1)
    following = FollowingMonitor(TOLERANCE, PERIOD)
    for command, measured in zip(told, lagging(told, times, lag), strict=True):
        assert following.command(command, measured, 0.0).told <= STILL


@pytest.mark.parametrize("age", [0.0, 0.1, 0.25, 0.5, 2.0])
@pytest.mark.parametrize("count", [1, 9, 31, 80])
def test_an_old_sample_of_a_resting_arm_is_no_following_error(age, count):
    following = FollowingMonitor(TOLERANCE, PERIOD)
    for _ in range(count):
        lag = following.command(np.ones(6), np.ones(6), age)
    assert (lag.beyond, lag.lasts, lag.told, lag.went) == (0.0, 0, 0.0, 0.0)
