"""Zeroing the force sensor: what it refuses, in which order it works, and who may vouch for a force."""

import numpy as np
import pytest
from bathbot_scrub.arm.errors import NotReadyError, RefusedError
from bathbot_scrub.arm.force_limits import shipped_force_limits
from bathbot_scrub.rm65.force.wrench_filter import HeadWrench
from bathbot_scrub.rm65.force.zeroing import Zeroing

LIMITS = shipped_force_limits()


class Sensor:
    """A sensor whose force [N] along z is a function of time; zeroing takes away what is there."""

    def __init__(self, force, remains=0.0):
        self.now, self.force, self.remains, self.zero = 0.0, force, remains, 0.0
        self.done = []  # what was done and when
        self.zeroing = Zeroing(self.clear, self.newest, self.restart, self)

    def __call__(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds

    def newest(self):
        force = self.force(self.now)
        if force is None:
            return None
        wrench = np.array([0.0, 0.0, force - self.zero, 0.0, 0.0, 0.0])
        return HeadWrench(self.now, wrench, wrench, wrench, ())

    def clear(self):
        self.done.append(("clear", self.now))
        self.zero = self.force(self.now) - self.remains

    def restart(self):
        self.done.append(("restart", self.now))

    def run(self):
        return self.zeroing.run(LIMITS)

    @property
    def cleared(self):
        return bool(self.done)


def test_it_watches_zeroes_and_lets_the_filter_settle_in_this_order():
    sensor = Sensor(lambda t: 2.5)
    assert sensor.run() == 0.0
    (cleared, at), (restarted, then) = sensor.done
    assert (cleared, restarted) == ("clear", "restart")
    assert at >= 0.05 - 1e-9  # watched
    assert then >= at + 0.03 - 1e-9  # samples older than the reply are gone
    assert sensor.now >= then + 0.15 - 1e-9  # the filter forgets where it began
    assert sensor.zero == 2.5


@pytest.mark.parametrize("when", [0.006, 0.025, 0.044])
def test_a_touch_at_any_time_of_watching_is_not_zeroed(when):
    """50 ms are watched, ten samples of the push: a hand that is just coming is seen."""
    sensor = Sensor(lambda t: 0.0 if t < when else 0.6)
    with pytest.raises(NotReadyError, match="something touches the head"):
        sensor.run()
    assert not sensor.cleared


def test_a_slow_change_below_what_may_remain_is_let_be():
    assert Sensor(lambda t: 9.0 * min(t, 0.05)).run() == 0.0


@pytest.mark.parametrize("axis", range(3))
def test_each_axis_of_the_force_is_watched(axis):
    sensor = Sensor(lambda t: 0.0)

    def newest():
        wrench = np.zeros(6)
        wrench[axis] = 0.7 * (sensor.now > 0.02)
        return HeadWrench(sensor.now, wrench, wrench, wrench, ())

    with pytest.raises(NotReadyError, match=r"0\.70 N"):
        Zeroing(sensor.clear, newest, sensor.restart, sensor).run(LIMITS)


def test_the_first_zeroing_is_bound_like_all_others():
    """A driver that was started again on the skin: 10.7 N are a person, not drift."""
    sensor = Sensor(lambda t: -10.7)
    with pytest.raises(NotReadyError, match=r"10\.7 N are felt where nothing should be.*arm/resume"):
        sensor.run()
    assert not sensor.cleared


def test_the_bound_is_what_may_be_felt_in_free_air():
    assert Sensor(lambda t: LIMITS.transit - 0.01).run() == 0.0
    with pytest.raises(NotReadyError):
        Sensor(lambda t: LIMITS.transit + 0.01).run()


def test_somebody_vouches_for_one_zeroing_and_only_when_asked():
    drift = [-6.0]
    sensor = Sensor(lambda t: drift[0])
    assert sensor.zeroing.allow() is False
    for _ in range(2):  # what nobody had asked for is no word
        with pytest.raises(NotReadyError):
            sensor.run()
    assert sensor.zeroing.allow() is True
    assert sensor.zeroing.allow() is False
    assert sensor.run() == 0.0
    drift[0] = -12.0
    with pytest.raises(NotReadyError, match=r"6\.0 N"):
        sensor.run()


def test_a_word_given_does_not_hide_a_touch():
    sensor = Sensor(lambda t: -6.0)
    with pytest.raises(NotReadyError):
        sensor.run()
    sensor.zeroing.allow()
    sensor.force = lambda t: -6.0 - 0.6 * (t % 0.04 > 0.02)
    with pytest.raises(NotReadyError, match="changes by"):
        sensor.run()


def test_what_remains_is_refused_and_leaves_no_word_behind():
    sensor = Sensor(lambda t: 0.0, remains=0.51)
    with pytest.raises(NotReadyError, match=r"0\.51 N remain"):
        sensor.run()
    assert Sensor(lambda t: 0.0, remains=0.49).run() == pytest.approx(0.49)


@pytest.mark.parametrize("force", [None, np.nan], ids=["nothing yet", "not a number"])
def test_without_a_force_nothing_is_zeroed(force):
    sensor = Sensor(lambda t: force)
    with pytest.raises(NotReadyError, match="no force is measured"):
        sensor.run()
    assert not sensor.cleared


def test_a_sensor_that_falls_silent_behind_the_zeroing_is_not_zeroed():
    sensor = Sensor(lambda t: 0.0 if t < 0.1 else None)
    with pytest.raises(NotReadyError, match="remain"):
        sensor.run()


def test_a_controller_that_refuses_is_told_and_the_filter_goes_on():
    sensor = Sensor(lambda t: 0.0)

    def refuse():
        raise RefusedError("no")

    with pytest.raises(RefusedError):
        Zeroing(refuse, sensor.newest, sensor.restart, sensor).run(LIMITS)
    assert not sensor.done
