"""The rule by which the arm leaves before the bristles' give is used up: at any rate, and not for noise.

The brush gives 10 mm at 0.4 N/mm. Behind that is skin, up to 75 N/mm of it.
"""

import math

import numpy as np
import pytest
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from bathbot_scrub.arm.errors import ArmSettingsError
from bathbot_scrub.arm.force_limits import ForceLimits, shipped_force_limits
from bathbot_scrub.arm.states import QUIET, Action
from bathbot_scrub.rm65.force.wrench_filter import Trend, WrenchFilter
from bathbot_scrub.rm65.guard.force_checks import Reading, noise_ratio, surge
from bathbot_scrub.rm65.guard.force_guard import ForceGuard
from hypothesis import given
from hypothesis import strategies as st

LIMITS = shipped_force_limits()
CYCLE, NOISE = 0.005, 0.05  # [s] of the push, [N] of each axis of the sensor
STIFFNESS = LIMITS.give / SCRUB_HEAD.give  # [N/m]
WINDOWS = (5, 9, 17)
TEN_HOURS = 36000.0 / CYCLE  # samples


def after_decision(speed):
    """How much farther [m] a body comes at `speed` [m/s] behind the sample that decides.

    As measured in the emulator, by the true head: the joints need that long to be as fast as the body.
    """
    return float(np.interp(speed, [0.0, 0.04, 0.06, 0.1, 0.15, 0.2], [0, 4e-4, 9e-4, 1.95e-3, 4.15e-3, 7e-3]))


def decided_at(force, seed=0, settled=True):
    """Time [s] and force [N] at which the arm leaves a force(t) [N]; None when it never does in that time."""
    rng, filtered = np.random.default_rng(seed), WrenchFilter(15.0)
    for index, now in enumerate(force):
        wrench = [*rng.normal(0.0, NOISE, 2), rng.normal(-now, NOISE), 0.0, 0.0, 0.0]
        if surge(filtered.update(CYCLE * index, wrench).trends, LIMITS, settled):
            return CYCLE * index, now
    return None


def ramp(begin, speed, seconds=4.0):
    """Force [N] of a resting brush, 0.3 s at rest and then pressed at `speed` [m/s]."""
    times = np.arange(0.0, seconds, CYCLE)
    return begin + STIFFNESS * speed * np.maximum(times - 0.3, 0.0)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("rest", [1.0, 1.43, 2.0])
@pytest.mark.parametrize("speed", [0.005, 0.01, 0.02, 0.03, 0.04, 0.06, 0.08, 0.10])
def test_a_body_at_any_speed_is_left_before_the_give_is_used(speed, rest, seed):
    found = decided_at(ramp(rest, speed), seed)
    assert found is not None
    assert found[1] / STIFFNESS + after_decision(speed) < SCRUB_HEAD.give


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("speed", [0.03, 0.04, 0.05, 0.06])
def test_slow_rises_are_known_before_the_force_itself_is_too_high(speed, seed):
    """Below `surge`, by the longer windows: 1 mm of give is left when the head is as fast as the body."""
    _, force = decided_at(ramp(1.43, speed), seed)
    assert force < LIMITS.used_up - 0.1
    assert force / STIFFNESS + after_decision(speed) < SCRUB_HEAD.give - 0.001


@pytest.mark.parametrize("seed", range(5))
def test_from_where_a_search_ends_that_holds_up_to_150_mm_a_second(seed):
    """A search ends at 1.43 N in the emulator; at 200 mm/s the joints could not do it even with no delay."""
    _, force = decided_at(ramp(1.43, 0.15), seed)
    assert force / STIFFNESS + after_decision(0.15) < SCRUB_HEAD.give
    assert 1.43 / STIFFNESS + after_decision(0.2) > SCRUB_HEAD.give


@given(begin=st.floats(0.5, 3.0), speed=st.floats(0.0005, 0.3))
def test_without_noise_no_ramp_at_all_comes_near_the_end_of_the_give(begin, speed):
    found = decided_at_quietly(begin, speed)
    assert found < LIMITS.give - 0.3 or found < begin + STIFFNESS * speed * 0.03


def decided_at_quietly(begin, speed):
    """Force [N] at which the arm leaves, by trends of a ramp that has begun 0.2 s ago or is beginning."""
    for force in np.arange(begin, 6.0, 0.005):
        trends = tuple(Trend(n, CYCLE * (n - 1), force, STIFFNESS * speed) for n in WINDOWS)
        if surge(trends, LIMITS, True):
            return force
    return math.inf


def tail(sigmas):
    """Share of a normal distribution beyond so many standard deviations."""
    return 0.5 * math.erfc(sigmas / math.sqrt(2.0))


def expected(force, rise, samples):
    """How often noise lets the arm leave a force [N] that rises [N/s], in so many samples; an upper bound."""
    total = 0.0
    for count in WINDOWS:
        spread = CYCLE * math.sqrt(count * (count**2 - 1) / 12.0)
        slope_noise, half = NOISE / spread, CYCLE * (count - 1) / 2.0
        least = noise_ratio(count) * LIMITS.surge
        ahead = NOISE * math.sqrt(1.0 / count + ((half + 0.08) / spread) ** 2)
        total += min(tail((least - rise) / slope_noise), tail((LIMITS.give - force - 0.08 * rise) / ahead))
    longest = WINDOWS[-1]
    now = NOISE * math.sqrt(4.0 / longest)
    return samples * (total + tail((LIMITS.used_up - force) / now))


def test_the_slope_s_noise_is_what_the_rule_takes_it_for():
    """By 4000 windows of noise each: the constants of `expected`, and the ratio that the rule uses."""
    rng = np.random.default_rng(0)
    slopes = {count: [] for count in WINDOWS}
    for _ in range(200):
        filtered = WrenchFilter(15.0)
        for index in range(60):
            wrench = filtered.update(CYCLE * index, [0, 0, rng.normal(-2.0, NOISE), 0, 0, 0])
            for trend in wrench.trends:
                slopes[trend.count].append(trend.rise)
    found = {count: np.std(values) for count, values in slopes.items()}
    assert found[5] == pytest.approx(3.16, rel=0.05)
    for count in WINDOWS:
        assert found[count] / found[5] == pytest.approx(noise_ratio(count), rel=0.07)
    assert LIMITS.surge / 3.16 > 7.9


@pytest.mark.parametrize(
    ("what", "force", "rise"),
    [
        ("noise at the upper end of the gentlest band", 3.0, 0.0),
        ("a body that breathes 10 mm to and fro at 0.25 Hz, where it is fastest", 3.0, 0.4 * 7.9),
        ("the deepest press that is planned, and a breath of 2 mm", 3.1, 0.0),
    ],
)
def test_noise_alone_makes_it_leave_less_than_once_in_ten_hours(what, force, rise):
    assert expected(force, rise, TEN_HOURS) < 1.0, what


def test_an_edge_at_full_speed_may_last_an_hour():
    assert expected(2.4, 10.0, 3600.0 / CYCLE) < 1.5
    assert expected(2.4, 10.0, 0.1 / CYCLE) < 1e-4  # one edge


@pytest.mark.parametrize("middle", [1.25, 2.0, 2.6])
def test_a_breathing_body_is_never_left_while_the_brush_is_in_the_band(middle):
    """2 mm to and fro at 0.25 Hz, for half a minute, about any press of the band that leaves room for it."""
    times = np.arange(0.0, 30.0, CYCLE)
    breath = STIFFNESS * 0.001 * np.sin(2.0 * np.pi * 0.25 * times)
    assert decided_at(middle + breath, seed=3) is None


def test_noise_in_fact_lets_the_arm_be():
    """A minute at the end of the band."""
    assert decided_at(np.full(12_000, 3.0), seed=1) is None


@pytest.mark.parametrize("region", LIMITS.regions)
def test_no_press_that_is_planned_reaches_what_a_breath_would_use_up(region):
    for wanted in np.arange(0.0, 0.02, 0.0005):
        press = LIMITS.comfortable(region, wanted)
        assert STIFFNESS * (press + 0.002) < LIMITS.used_up
    assert LIMITS.comfortable(region, 0.005) == 0.005


def test_limits_without_room_between_contact_and_the_end_of_the_give_are_refused():
    with pytest.raises(ArmSettingsError, match="zero_residual"):
        ForceLimits(1.0, 0.5, 3.0, 25.0, 1.4, LIMITS.regions)


def test_the_head_s_own_way_to_the_skin_is_no_surge_and_a_body_that_meets_it_is():
    """30 mm/s of the arm; 150 mm/s together with the body."""
    assert decided_at(ramp(0.0, 0.03, 0.3 + 0.12), settled=False) is None
    assert decided_at(ramp(0.0, 0.15, 0.3 + 0.05), settled=False) is not None


@pytest.mark.parametrize(("since", "action"), [(0.085, Action.GO_ON), (0.095, Action.RETRACT)])
def test_a_trend_counts_when_all_of_it_could_be_trusted(since, action):
    guard = ForceGuard(LIMITS)
    guard.vouch("at home")
    guard.begin_approach(LIMITS.region("Trunk_skin"))
    guard.begin_seeking()
    pressed = np.array([0.0, 0.0, -3.6, 0.0, 0.0, 0.0])
    felt = Reading(1.0, pressed, pressed, pressed, (Trend(17, 0.08, 3.6, 0.0),), 0.0)
    assert guard.check(felt._replace(trends=()), QUIET, False) is Action.STOP
    guard.check(felt._replace(stamp=2.0, wrench=pressed * np.nan), QUIET, False)
    guard.check(felt._replace(stamp=2.005, trends=()), QUIET, False)
    assert guard.check(felt._replace(stamp=2.0 + since), QUIET, False) is action
