"""Settings: what they allow, what they say, and what ROS is told of them."""

import math
from dataclasses import dataclass

import pytest
from bathbot_depthcorr.errors import SettingsError
from bathbot_depthcorr.node.parameters import Setting, check, same, setting
from bathbot_depthcorr.node.parameters_node import descriptor

SPEED = Setting(0.5, "Speed of something that moves; slow is safe", "m/s", above=0.0, high=2.0)


@pytest.mark.parametrize(
    ("entry", "rule", "good", "bad"),
    [
        pytest.param(
            SPEED, "must lie in 0..2 m/s, 0 left out", [1e-9, 2.0], [0.0, 2.1, math.nan], id="half open"
        ),
        pytest.param(Setting(3, "", low=1, high=9), "must lie in 1..9", [1, 9], [0, 10], id="closed"),
        pytest.param(Setting(1.0, "", "s", low=0.0), "must be 0 s or more", [0.0, math.inf], [-1.0]),
        pytest.param(
            Setting(1.0, "", "s", above=0.0, below=math.inf), "must be positive and finite", [1e-9],
            [0.0, math.inf, math.nan], id="finite",
        ),
        pytest.param(Setting(1.0, "", "m", above=0.1), "must be above 0.1 m", [0.2], [0.1], id="above"),
        pytest.param(Setting(1.0, "", high=5.0), "must be at most 5", [5.0, -9.0], [5.1], id="high"),
        pytest.param(Setting(1.0, "", below=5.0), "must be below 5", [4.9], [5.0], id="below"),
        pytest.param(
            Setting(3, "", low=1, step=2), "must be 1 or more, in steps of 2", [1, 7], [4, -1], id="odd"
        ),
        pytest.param(Setting("a", "", choices=("a", "b")), "must be one of a, b", ["b"], ["c"], id="choices"),
        pytest.param(
            Setting((0.0, 0.0), "", length=2, low=0.0, high=1.0),
            "must be 2 numbers, each of which must lie in 0..1",
            [(1.0, 0.0)], [(1.0,), (0.5, 1.5)], id="numbers",
        ),
        pytest.param(Setting("", "any words"), "", ["", "x"], [], id="words"),
    ],
)  # fmt: skip
def test_a_rule_says_what_it_allows(entry, rule, good, bad):
    assert entry.rule == rule
    assert [value for value in good if not entry.allows(value)] == []
    assert [value for value in bad if entry.allows(value)] == []


def test_the_unit_stands_behind_the_first_clause():
    assert SPEED.description == "Speed of something that moves [m/s]; slow is safe"
    assert Setting(1, "Number of things").description == "Number of things"


@dataclass(frozen=True)
class Upstream:
    rate: float = setting(
        5.0, "Rate of something that is done again and again", "Hz", above=0.0, below=math.inf
    )

    def __post_init__(self) -> None:
        check(self, SettingsError)


@dataclass(frozen=True)
class Downstream:
    rate: float = same(Upstream, "rate")
    count: int = setting(2, "Number of things that are counted somewhere", low=1)

    def __post_init__(self) -> None:
        check(self, SettingsError)


@pytest.mark.parametrize("kind", [Upstream, Downstream])
def test_a_shared_setting_is_checked_wherever_it_stands(kind):
    assert kind().rate == 5.0
    with pytest.raises(SettingsError, match=r"^rate must be positive and finite, got -1\.0; the default"):
        kind(rate=-1.0)


def test_ros_is_told_meaning_range_and_rule():
    told = descriptor(SPEED)
    assert told.description == "Speed of something that moves [m/s]; slow is safe"
    assert told.additional_constraints == "must lie in 0..2 m/s, 0 left out"
    assert (told.floating_point_range[0].from_value, told.floating_point_range[0].to_value) == (0.0, 2.0)
    assert told.read_only
    assert told.dynamic_typing, "or an integer for a float would be refused"


def test_open_ends_of_whole_numbers_fit_into_64_bits():
    (told,) = descriptor(Setting(3, "", low=1, step=2)).integer_range
    assert (told.from_value, told.to_value, told.step) == (1, 2**63 - 1, 2)


@pytest.mark.parametrize("entry", [Setting("", "words"), Setting(True, "truth"), Setting(1.0, "anything")])
def test_without_a_rule_there_is_no_range(entry):
    told = descriptor(entry)
    assert not told.floating_point_range
    assert not told.integer_range
    assert told.additional_constraints == ""
