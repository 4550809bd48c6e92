"""What the watchdogs look at, from samples and commands."""

import numpy as np
import pytest
from bathbot_scrub.rm65.controller.state_push import ArmSample
from bathbot_scrub.rm65.guard.signal_health import Activity, Connected, SignalHealth

TCP, BUSY = Connected(True, "", 0.0), Activity(False, 0.0, False)
PERIOD, TOLERANCE = 0.01, 0.01


def sample(stamp, wrench=None, joints=None, **changes):
    wrench = np.random.default_rng(round(1e6 * stamp)).normal(0.0, 0.05, 6) if wrench is None else wrench
    joints = np.zeros(6) if joints is None else joints
    values = {"errors": (), "joint_errors": (0,) * 6, "status": "idle"} | changes
    wrench = np.asarray(wrench, dtype=float)
    return ArmSample(stamp, joints, wrench, wrench, np.eye(4), **values)


def fed(*samples):
    health = SignalHealth(TOLERANCE, PERIOD)
    for one in samples:
        health.sample(one)
    return health


def test_before_the_first_sample_nothing_is_known_and_nothing_is_wrong_but_the_silence():
    signals = SignalHealth(TOLERANCE, PERIOD).signals(5.0, TCP, BUSY)
    assert signals.age == np.inf
    assert (signals.repeats, signals.late, signals.errors, signals.finite) == (0, 0, (), True)


def test_age_counts_on_and_a_stamp_from_the_future_is_not_negative():
    health = fed(sample(1.0))
    assert health.signals(1.02, TCP, BUSY).age == pytest.approx(0.02)
    assert health.signals(0.5, TCP, BUSY).age == 0.0


def test_readings_that_came_before_are_counted_and_a_live_sensor_never_repeats_itself():
    live = [sample(0.005 * k) for k in range(300)]
    assert fed(*live).signals(1.5, TCP, BUSY).repeats == 0
    frozen = [sample(1.5 + 0.005 * k, live[-1].wrench) for k in range(20)]
    assert fed(*live, *frozen).signals(1.6, TCP, BUSY).repeats == 20
    old = [sample(1.5 + 0.005 * k, live[200 + k].wrench) for k in range(20)]
    assert fed(*live, *old).signals(1.6, TCP, BUSY).repeats == 20
    half_rate = [sample(0.005 * k, live[k // 2].wrench) for k in range(100)]
    assert fed(*half_rate).signals(1.6, TCP, BUSY).repeats <= 1


def test_samples_that_arrive_at_once_were_late_and_that_is_forgotten_after_a_while():
    health = fed(sample(1.0), *[sample(1.1 + 1e-4 * k) for k in range(20)])
    assert health.signals(1.11, TCP, BUSY).late == 20
    assert health.signals(1.2, TCP, BUSY).late == 0


def test_datagrams_that_cannot_be_read_count_until_one_can():
    health = fed(sample(1.0))
    health.refuse()
    health.refuse()
    assert health.signals(1.1, TCP, BUSY).refused == 2
    health.sample(sample(1.2))
    assert health.signals(1.2, TCP, BUSY).refused == 0


@pytest.mark.parametrize("axis", range(6))
def test_a_force_of_which_one_part_is_no_number_is_none(axis):
    broken = np.where(np.arange(6) == axis, np.nan, 0.1)
    signals = fed(*[sample(0.005 * k, broken) for k in range(20)]).signals(0.1, TCP, BUSY)
    assert not signals.finite
    assert signals.repeats == 0  # that is said by `finite`, and never the same as itself


def test_a_joint_that_stands_is_found_however_long_the_machine_has_run():
    """The age of a sample is what is not known of the joints: counted from its stamp, at any time of day."""
    health = SignalHealth(TOLERANCE, PERIOD)
    for count in range(40):
        now = 5000.0 + PERIOD * count
        health.sample(sample(now - 0.003))
        health.command(np.full(6, 0.01 * count), now)
    signals = health.signals(5000.4, TCP, BUSY)
    assert signals.lag.lasts > 10
    assert signals.lag.beyond > 2 * TOLERANCE


def test_a_sample_that_is_old_explains_as_much_of_a_lag_as_it_is_old():
    """Commands of 0.3 rad/s; the joints are where they were told to be 0.20 s ago, or seem so only."""
    lags = []
    for late in (0.0, 0.15):
        health = SignalHealth(TOLERANCE, PERIOD)
        for count in range(100):
            now = 5000.0 + PERIOD * count
            health.sample(sample(now - late, joints=np.full(6, 0.003 * (count - 20))))
            health.command(np.full(6, 0.003 * count), now)
        lags.append(health.signals(5001.0, TCP, BUSY).lag)
    assert lags[0].lasts > 10
    assert lags[1].lasts == 0
