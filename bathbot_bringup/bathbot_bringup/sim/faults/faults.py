"""How a fault of the emulated controller is written down.

A fault is ordered as a mapping, in a scenario file, on the topic `sim_fault` or in Python:
`{kind: lost_udp, after: 2.0, duration: 1.5, value: 0.3}`; only `kind` must be there.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import yaml
from bathbot_depthcorr.bounded_files import parse_yaml

from bathbot_bringup.errors import SettingsError
from bathbot_bringup.sim.faults.kinds import KINDS


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
        mapping = parse_yaml(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise SettingsError(f"a fault is YAML such as {{kind: lost_udp}}, got {text!r:.80}") from error
    return parse_fault(mapping)


def _float(number: float) -> float:
    try:
        return float(number)
    except OverflowError:  # an integer of hundreds of digits
        return math.inf
