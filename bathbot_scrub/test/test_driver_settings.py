"""Parameters of the arm driver that mean nothing are refused in one line."""

import pytest
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
        ({"standoff": -0.1}, "positive"),
        ({"retract_speed": float("nan")}, "positive"),
        ({"queue_length": 1}, "2 or more"),
        ({"home_deg": (0.0,)}, "6 numbers"),
        ({"home_deg": (0.0, 140.0, 0.0, 0.0, 0.0, 0.0)}, "joint 2"),
    ],
)
def test_meaningless_values_are_refused(change, told):
    with pytest.raises(ArmError, match=told) as caught:
        DriverSettings(**change)
    assert "\n" not in str(caught.value)
