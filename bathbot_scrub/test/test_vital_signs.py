"""What the watchdogs look at, from samples and commands."""

import time

import numpy as np
import pytest
from bathbot_scrub.rm65.controller.state_push import ArmSample
from bathbot_scrub.rm65.errors import InvalidPoseError
from bathbot_scrub.rm65.force.tool_weight import ToolWeight, estimate
from bathbot_scrub.rm65.guard.following_error import Following
from bathbot_scrub.rm65.guard.signal_health import Activity, Connected, VitalSigns
from bathbot_scrub.rm65.timing.stream_statistics import ReactionStatistics
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

TCP, BUSY = Connected(True, "", 0.0), Activity(False, 0.0, False)
PERIOD, TOLERANCE, STILL = 0.01, 0.01, 0.0015


def sample(stamp, wrench=None, joints=None, **changes):
    wrench = np.random.default_rng(round(1e6 * stamp)).normal(0.0, 0.05, 6) if wrench is None else wrench
    joints = np.zeros(6) if joints is None else joints
    values = {"errors": (), "joint_errors": (0,) * 6, "status": "idle"} | changes
    wrench = np.asarray(wrench, dtype=float)
    return ArmSample(stamp, joints, wrench, wrench, np.eye(4), **values)


def fed(*samples):
    vitals = VitalSigns(TOLERANCE, PERIOD)
    for one in samples:
        vitals.sample(one)
    return vitals


def test_before_the_first_sample_nothing_is_known_and_nothing_is_wrong_but_the_silence():
    signs = VitalSigns(TOLERANCE, PERIOD).signs(5.0, TCP, BUSY)
    assert signs.age == np.inf
    assert (signs.repeats, signs.late, signs.errors, signs.finite) == (0, 0, (), True)


def test_age_counts_on_and_a_stamp_from_the_future_is_not_negative():
    vitals = fed(sample(1.0))
    assert vitals.signs(1.02, TCP, BUSY).age == pytest.approx(0.02)
    assert vitals.signs(0.5, TCP, BUSY).age == 0.0


def test_the_clock_of_the_day_does_not_matter(monkeypatch):
    vitals = fed(sample(1.0))
    monkeypatch.setattr(time, "time", lambda: 0.0)
    assert vitals.signs(1.01, TCP, BUSY).age == pytest.approx(0.01)


def test_readings_that_came_before_are_counted_and_a_live_sensor_never_repeats_itself():
    live = [sample(0.005 * k) for k in range(300)]
    assert fed(*live).signs(1.5, TCP, BUSY).repeats == 0
    frozen = [sample(1.5 + 0.005 * k, live[-1].wrench) for k in range(20)]
    assert fed(*live, *frozen).signs(1.6, TCP, BUSY).repeats == 20
    old = [sample(1.5 + 0.005 * k, live[200 + k].wrench) for k in range(20)]
    assert fed(*live, *old).signs(1.6, TCP, BUSY).repeats == 20
    half_rate = [sample(0.005 * k, live[k // 2].wrench) for k in range(100)]
    assert fed(*half_rate).signs(1.6, TCP, BUSY).repeats <= 1


def test_samples_that_arrive_at_once_were_late_and_that_is_forgotten_after_a_while():
    vitals = fed(sample(1.0), *[sample(1.1 + 1e-4 * k) for k in range(20)])
    assert vitals.signs(1.11, TCP, BUSY).late == 20
    assert vitals.signs(1.2, TCP, BUSY).late == 0


def test_datagrams_that_cannot_be_read_count_until_one_can():
    vitals = fed(sample(1.0))
    vitals.refuse()
    vitals.refuse()
    assert vitals.signs(1.1, TCP, BUSY).refused == 2
    vitals.sample(sample(1.2))
    assert vitals.signs(1.2, TCP, BUSY).refused == 0


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
    following = Following(TOLERANCE, PERIOD)
    for command, measured in zip(told, lagging(told, times, lag + age), strict=True):
        found = following.command(command, measured, age)
        assert found.lasts == 0
        assert found.told <= STILL


@given(joint=st.integers(0, 5), speed=st.floats(0.1, 1.0))
@settings(max_examples=30)
def test_a_joint_that_jams_is_found_and_named(joint, speed):
    following, found = Following(TOLERANCE, PERIOD), []
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
    following, found = Following(TOLERANCE, PERIOD), []
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
    following = Following(TOLERANCE, PERIOD)
    for command, measured in zip(told, lagging(told, times, lag), strict=True):
        assert following.command(command, measured, 0.0).told <= STILL


def test_reactions_are_counted():
    reactions = ReactionStatistics()
    assert (reactions.p99(), reactions.count) == (0.0, 0)
    for seconds in (0.006, 0.007, 0.012):
        reactions.add(seconds)
    assert (reactions.longest, reactions.count) == (0.012, 3)
    assert 0.007 < reactions.p99() <= 0.012


rotations = st.integers(0, 10_000).map(lambda seed: Rotation.random(6, rng=seed).as_matrix())
centres = st.tuples(*[st.floats(-0.1, 0.1)] * 3)


@given(rotations=rotations, mass=st.floats(0.05, 2.0), centre=centres, seed=st.integers(0, 99))
def test_the_weight_is_found_from_postures_whatever_the_bias(rotations, mass, centre, seed):
    tool = ToolWeight(mass, np.array(centre))
    bias = np.random.default_rng(seed).normal(0.0, 3.0, 6)
    found = estimate(rotations, tool.pull(rotations) + bias)
    assert_allclose(found.mass, mass, atol=1e-9)
    assert_allclose(found.centre, centre, atol=1e-8)
    # what is left after zeroing at one posture does not change with the posture any more
    left = tool.pull(rotations) - (found.pull(rotations) - found.pull(rotations[0]))
    assert_allclose(left, np.tile(tool.pull(rotations[0]), (len(rotations), 1)), atol=1e-8)


def test_weight_by_hand_upright_and_on_its_side():
    tool = ToolWeight(0.5, np.array([0.0, 0.0, 0.05]))
    assert_allclose(tool.pull(np.eye(3)), [0.0, 0.0, -4.903325, 0.0, 0.0, 0.0])
    side = Rotation.from_euler("x", 90, degrees=True).as_matrix()
    assert_allclose(tool.pull(side), [0.0, -4.903325, 0.0, 0.24516625, 0.0, 0.0], atol=1e-12)


def test_postures_that_do_not_turn_the_sensor_tell_no_weight():
    turned = Rotation.from_euler("z", [[0], [40], [80]], degrees=True).as_matrix()
    with pytest.raises(InvalidPoseError, match="three or more"):
        estimate(turned, np.zeros((3, 6)))


@pytest.mark.parametrize("age", [0.0, 0.1, 0.25, 0.5, 2.0])
@pytest.mark.parametrize("count", [1, 9, 31, 80])
def test_an_old_sample_of_a_resting_arm_is_no_following_error(age, count):
    following = Following(TOLERANCE, PERIOD)
    for _ in range(count):
        lag = following.command(np.ones(6), np.ones(6), age)
    assert (lag.beyond, lag.lasts, lag.told, lag.went) == (0.0, 0, 0.0, 0.0)
