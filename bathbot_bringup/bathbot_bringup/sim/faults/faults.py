"""What can be made to fail in the emulated controller, and how a fault is written down.

A fault is ordered as a mapping, in a scenario file, on the topic `sim_fault` or in Python:
`{kind: lost_udp, after: 2.0, duration: 1.5, value: 0.3}`; only `kind` must be there.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import yaml

from bathbot_bringup.errors import SettingsError

NONE = "none"


class Kind(NamedTuple):
    """What a kind of fault does, and what its value means."""

    about: str  # one line
    value: float = math.nan  # taken when none is given; NaN: this kind has no value
    lowest: float = -math.inf
    highest: float = math.inf


KINDS: dict[str, Kind] = {
    NONE: Kind("ends all faults and those that wait, and puts the body back"),
    # the force sensor
    "stale_force": Kind("the force is `value` [s] old when it is pushed", 0.5, 0.005, 5.0),
    "frozen_force": Kind("the force sensor repeats its last reading"),
    "biased_force": Kind("`value` [N] more along the sensor's z; negative: as if pressed", -12.0, -400, 400),
    "drifting_force": Kind("the force drifts by `value` [N/s] along the sensor's z", -4.0, -400, 400),
    "nan_force": Kind("the force is no number: null in JSON"),
    "saturated_force": Kind("the force stands at `value` [N] along the sensor's z", -200.0, -400, 400),
    "dead_force": Kind("the force sensor is gone: zeros, and error 0x2003"),
    # the state push
    "lost_udp": Kind("no datagram leaves"),
    "slow_udp": Kind("one datagram in `value` [s]", 0.3, 0.005, 60.0),
    "frozen_udp": Kind("the last datagram is sent again and again"),
    "garbled_udp": Kind("every datagram is cut off in the middle"),
    "time_jump": Kind("datagrams are held back for `value` [s], then all come at once, again and again",
                      0.3, 0.005, 10.0),
    # the TCP sessions
    "dropped_tcp": Kind("clients are cut off, and new ones at once, as long as it lasts"),
    "slow_reply": Kind("replies and events come `value` [s] late; the joint stream is taken in time",
                       1.0, 0.0, 60.0),
    "deaf_tcp": Kind("clients may connect; nothing is answered, nothing obeyed"),
    # the joints
    "joint_error": Kind("joint `value` reports overcurrent and brakes; the arm stops", 3, 1, 6),
    "following_error": Kind("joint `value` is jammed; noticed 2 deg later, then the arm stops", 3, 1, 6),
    "collision_stop": Kind("the controller believes in a collision: the arm stops, error 0x100D"),
    # all of it
    "power_cut": Kind("no power: brakes fall in, nothing answers, TCP hangs half open; comes back with "
                      "the arm switched off"),
    "stalled": Kind("the controller freezes: the joints go on to the last target, frames wait until it ends"),
    # the person
    "body_push": Kind("the body comes towards the head with `value` [m/s], 0.3 m at most", 0.1, 0.0, 2.0),
    "body_away": Kind("the body leaves the head with `value` [m/s], 0.3 m at most", 0.1, 0.0, 2.0),
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is to fail.

    Attributes:
        kind: A key of `KINDS`.
        after: When it begins, from the moment it is ordered [s].
        duration: How long it lasts [s].
        value: How strong it is, see `KINDS`; the kind's own where none is given.
    """

    kind: str
    after: float = 0.0
    duration: float = math.inf
    value: float = math.nan

    def __post_init__(self) -> None:
        """Refuse what cannot be ordered, and fill in the value."""
        if self.kind not in KINDS:
            raise SettingsError(f"unknown fault {self.kind!r}; known are {', '.join(KINDS)}")
        if not 0.0 <= self.after < math.inf:
            raise SettingsError(f"fault {self.kind}: after must be a time in s from 0, got {self.after}")
        if not self.duration > 0.0:
            raise SettingsError(f"fault {self.kind}: duration must be above 0 s, got {self.duration}")
        kind = KINDS[self.kind]
        if math.isnan(self.value):
            object.__setattr__(self, "value", float(kind.value))
        elif math.isnan(kind.value):
            raise SettingsError(f"fault {self.kind} has no value, got {self.value}; leave it out")
        elif not kind.lowest <= self.value <= kind.highest:
            raise SettingsError(
                f"fault {self.kind}: value must be {kind.lowest} to {kind.highest}, got {self.value}"
            )


def parse_fault(mapping: Mapping[str, Any]) -> Fault:
    """Read a fault as it is written in YAML.

    Raises:
        SettingsError: On anything that is not a fault.
    """
    known = [field.name for field in fields(Fault)]
    if not isinstance(mapping, Mapping) or "kind" not in mapping:
        raise SettingsError(
            f"a fault is a mapping such as {{kind: lost_udp, after: 2.0}}, got {mapping!r:.80}"
        )
    if unknown := [str(key) for key in mapping if key not in known]:
        raise SettingsError(f"a fault has an unknown key {unknown[0]!r:.40}; known are {', '.join(known)}")
    if not isinstance(mapping["kind"], str):
        raise SettingsError(f"the kind of a fault must be a word, got {mapping['kind']!r:.40}")
    values = {key: value for key, value in mapping.items() if key != "kind"}
    for key, value in values.items():
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise SettingsError(f"fault {mapping['kind']:.40}: {key} must be a number, got {value!r:.40}")
    return Fault(mapping["kind"], **{key: _float(value) for key, value in values.items()})


def read_fault(text: str) -> Fault:
    """Read a fault from YAML, `{kind: lost_udp, after: 2.0}`.

    Raises:
        SettingsError: On anything that is not a fault.
    """
    try:
        mapping = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise SettingsError(f"a fault is YAML such as {{kind: lost_udp}}, got {text!r:.80}") from error
    return parse_fault(mapping)


def _float(number: float) -> float:
    try:
        return float(number)
    except OverflowError:  # an integer of hundreds of digits
        return math.inf
