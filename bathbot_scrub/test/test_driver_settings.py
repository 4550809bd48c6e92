"""Parameters of the arm driver that mean nothing are refused in one line."""

import math

import pytest
from bathbot_depthcorr.node.parameters import declared
from bathbot_localize.arm.scrub_head import SCRUB_HEAD
from bathbot_scrub.arm.errors import ArmError
from bathbot_scrub.rm65.settings import DriverSettings


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"variant": "7F"}, "must be one of B, 6F, 6FB"),
        ({"host": ""}, "address"),
        ({"port": 0}, "1..65535"),
        ({"udp_port": 70000}, "0..65535"),
        ({"rate": 50.0}, "100..500"),
        ({"joint_share": 1.5}, "0..1"),
        ({"standoff": -0.1}, r"0\.02\.\.0\.3"),
        ({"retract_speed": float("nan")}, r"0\.15\.\.0\.5"),
        ({"queue_length": 1}, r"2\.\.100"),
        ({"home_deg": (0.0,)}, "6 numbers"),
        ({"home_deg": (0.0, 140.0, 0.0, 0.0, 0.0, 0.0)}, "joint 2"),
    ],
)
def test_meaningless_values_are_refused(change, told):
    with pytest.raises(ArmError, match=told) as caught:
        DriverSettings(**change)
    assert "\n" not in str(caught.value)


FREE = {"host", "port", "udp_port", "variant", "force_limits", "home_deg", "walls", "home_needs_consent"}
FREE |= {"vendor_topics"}  # words, addresses, and what has a rule of its own
BEYOND = [
    (name, value)
    for name, entry in declared(DriverSettings).items()
    if name not in FREE
    for value in (entry.least - 0.01 * (1.0 + abs(entry.least)), 1.01 * entry.most + 0.01, math.inf, math.nan)
]


@pytest.mark.parametrize(("name", "value"), BEYOND)
def test_nothing_that_acts_on_safety_goes_beyond_its_bounds(name, value):
    """Each number of the driver has a least and a greatest value, and is refused beyond, with both."""
    entry = declared(DriverSettings)[name]
    assert math.isfinite(entry.least)
    assert math.isfinite(entry.most)
    values = (value, 0.0, 0.0) if isinstance(entry.default, tuple) else value
    with pytest.raises(ArmError, match=f"^{name} must .*got") as caught:
        DriverSettings(**{name: values})
    assert f"{entry.most:g}" in str(caught.value)


def test_bounds_are_those_that_the_reasons_ask_for():
    """By hand: what a bound lets happen before the arm reacts, against the give of the bristles of 10 mm."""
    most = {name: entry.most for name, entry in declared(DriverSettings).items()}
    least = {name: entry.least for name, entry in declared(DriverSettings).items()}
    give = SCRUB_HEAD.give
    assert most["approach_speed"] * most["brake_after"] < give  # 9 mm towards the skin unseen
    assert 0.12 * most["approach_speed"] < give  # 24 readings of 5 ms from a frozen sensor: 7.2 mm
    assert 0.85 * most["following_tolerance"] < give  # the head at the end of the arm: 8.5 mm
    assert least["retract_speed"] > 0.1  # a body that follows at 100 mm/s is left behind
    assert least["standoff"] == 2.0 * give
    assert least["lift"] > give
    assert most["leave_after"] <= 20.0  # nobody is pressed for longer by an arm that has nothing to do
