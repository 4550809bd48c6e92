"""How the guard begins: in HOLD, until somebody says that nothing touches the head, or it stands at home."""

import numpy as np
import pytest
from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.states import QUIET, Action, Reaction, State
from bathbot_scrub.rm65.guard.first_samples import FirstSamples
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from test_guard import BROKEN, IDLE, LIMITS, SILENT, TRUNK, UNSTEADY, reading

HOME = np.radians([0.0, 60.0, -130.0, 0.0, -80.0, 0.0])


def shown(samples):
    """What samples (joints, force, alarm), 5 ms apart, decide; and how many it took."""
    first = FirstSamples(HOME, LIMITS.transit)
    for count, (joints, force, alarm) in enumerate(samples, 1):
        if first.show_home(reading((0.0, 0.0, -force), stamp=0.005 * count), joints, alarm):
            return True, count
        if first.decided:
            return False, count
    return None, len(samples)


def test_an_arm_that_has_just_started_moves_only_off_the_skin_until_somebody_says_it_is_free():
    guard = ForceGuard(LIMITS, needs_consent=False)
    assert guard.state is State.HOLD
    assert "arm/resume" in guard.reason
    assert "arm/retract" in guard.reason
    with pytest.raises(NotReadyError, match="nobody has said that nothing touches the head"):
        guard.begin_approach(TRUNK)
    for alarm in (QUIET, SILENT, BROKEN, IDLE):  # its zero is not known: no force makes it move
        assert guard.check(reading((0.0, 0.0, -10.7)), alarm, False) is Action.GO_ON
    assert guard.state is State.HOLD
    assert guard.resume() is False
    assert guard.state is State.FREE
    guard.begin_approach(TRUNK)


def test_a_retract_does_not_say_that_the_head_is_free():
    guard = ForceGuard(LIMITS)
    guard.begin_retract()
    guard.arrived("retracted")
    with pytest.raises(NotReadyError, match="arm/resume"):
        guard.begin_approach(TRUNK)
    with pytest.raises(NotReadyError, match="not just started"):
        guard.vouch("at home")
    guard.resume()
    guard.begin_approach(TRUNK)


def test_twenty_samples_at_home_with_little_force_show_that_nothing_touches():
    assert shown([(HOME + 0.04, 2.9, QUIET)] * 25) == (True, 20)


@pytest.mark.parametrize(
    "other",
    [
        pytest.param((HOME + np.eye(6)[3] * 0.06, 0.0, QUIET), id="elsewhere"),
        pytest.param((HOME * np.nan, 0.0, QUIET), id="no joints"),
        pytest.param((HOME, 3.1, QUIET), id="pressed"),
        pytest.param((HOME, np.nan, QUIET), id="no force"),
        pytest.param((HOME, 0.0, BROKEN), id="a joint's error"),
    ],
)
def test_one_sample_that_shows_something_else_needs_a_person(other):
    assert shown([(HOME, 0.0, QUIET)] * 19 + [other] + [(HOME, 0.0, QUIET)] * 20) == (False, 20)


def test_data_that_are_in_doubt_for_a_while_decide_nothing():
    good = (HOME, 0.0, QUIET)
    assert shown([good, (HOME, 9.0, SILENT)] * 25) == (True, 39)
    assert shown([(HOME, 0.0, UNSTEADY)] * 20) == (True, 20)


def test_one_sample_counts_once_and_none_before_the_first():
    first = FirstSamples(HOME, LIMITS.transit)
    for stamp in [np.nan, *[1.0] * 40]:
        assert not first.show_home(reading(stamp=stamp), HOME, QUIET)
    assert not first.decided


def test_a_driver_that_waited_long_for_its_controller_finds_the_arm_at_home_all_the_same():
    unsteady = UNSTEADY._replace(reaction=Reaction.FAULT, force=True, joints=True)
    assert shown([(HOME, 0.0, unsteady)] * 60 + [(HOME, 0.0, QUIET)] * 25) == (True, 80)
