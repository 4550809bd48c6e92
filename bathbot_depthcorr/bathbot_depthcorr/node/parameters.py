"""What a user may change, declared once: default, meaning, unit and range; one check for all of it.

A settings dataclass declares each field with `setting` and calls `check` in `__post_init__`, so that plain
Python is checked as a node is. `parameters_node` hands the same to ROS, for `ros2 param describe`.
"""

import math
from dataclasses import dataclass, field, fields
from typing import Any


@dataclass(frozen=True, slots=True)
class Setting:
    """One setting; a tuple's bounds hold for each of its numbers.

    Attributes:
        default: Value where the user says nothing.
        about: What it means, to somebody who reads nothing else.
        unit: Of the value, such as m/s; empty for shares, counts and words.
        low: Least value.
        above: Greatest value that is too small; None where `low` says all.
        high: Greatest value.
        below: Least value that is too great; None where `high` says all. `math.inf` asks for a finite value.
        step: Distance of allowed whole numbers, counted from `low`.
        length: How many numbers a tuple must hold; 0: any.
        choices: All values allowed; empty: any.
    """

    default: Any
    about: str
    unit: str = ""
    low: float = -math.inf
    above: float | None = None
    high: float = math.inf
    below: float | None = None
    step: int = 1
    length: int = 0
    choices: tuple[Any, ...] = ()

    @property
    def least(self) -> float:
        """Lower end of the range, itself allowed or not."""
        return self.low if self.above is None else self.above

    @property
    def most(self) -> float:
        """Upper end of the range, itself allowed or not."""
        return self.high if self.below is None else self.below

    @property
    def description(self) -> str:
        """Meaning, with the unit behind its first clause."""
        meaning, mark, more = self.about.partition(";")
        return f"{meaning} [{self.unit}]{mark}{more}" if self.unit else self.about

    @property
    def rule(self) -> str:
        """What a value must be, as the end of a sentence; empty where anything goes."""
        if self.choices:
            return f"must be one of {', '.join(str(choice) for choice in self.choices)}"
        bounds, numbers = self._bounds(), f"must be {self.length} numbers" if self.length else ""
        if numbers and bounds:
            return f"{numbers}, each of which {bounds}"
        return numbers or bounds

    def allows(self, value: Any) -> bool:
        """Whether a value of the default's type keeps the rule; NaN never does."""
        if self.choices:
            return value in self.choices
        if isinstance(value, tuple):
            return len(value) == (self.length or len(value)) and all(map(self._within, value))
        return self._within(value)

    def _within(self, value: Any) -> bool:
        if isinstance(value, str | bool):
            return True
        return (
            self.low <= value <= self.high
            and (self.above is None or value > self.above)
            and (self.below is None or value < self.below)
            and (self.step == 1 or (value - self.low) % self.step == 0)
        )

    def _bounds(self) -> str:
        least, most, unit = _told(self.least), _told(self.most), f" {self.unit}" if self.unit else ""
        if least and most:
            left_out = [_told(end) for end in (self.above, self.below) if end is not None]
            text = f"must lie in {least}..{most}{unit}"
            text += f", {' and '.join(left_out)} left out" if left_out else ""
        elif least:
            positive = "must be positive" if self.above == 0 else f"must be above {least}{unit}"
            text = positive if self.above is not None else f"must be {least}{unit} or more"
            text += " and finite" if self.below is not None else ""
        elif most:
            text = f"must be {'at most' if self.below is None else 'below'} {most}{unit}"
        else:
            text = ""
        return f"{text}, in steps of {self.step}" if self.step != 1 else text


def _told(end: float) -> str:
    """An end of a range in words; empty for an infinite one."""
    if math.isinf(end):
        return ""
    return f"{end:g}" if isinstance(end, float) else str(end)


def setting(default: Any, about: str, unit: str = "", **rule: Any) -> Any:
    """A dataclass field that is a setting; `rule` are the further attributes of `Setting`."""
    return field(default=default, metadata={"setting": Setting(default, about, unit, **rule)})


def same(settings_type: type, name: str) -> Any:
    """A field with the setting that another dataclass declares under this name."""
    entry = declared(settings_type)[name]
    return field(default=entry.default, metadata={"setting": entry})


def declared(settings_type: type) -> dict[str, Setting]:
    """All settings of a dataclass by name."""
    return {entry.name: entry.metadata["setting"] for entry in fields(settings_type)}


def check(settings: Any, error: type[Exception]) -> None:
    """Refuse a value that breaks its rule.

    Raises:
        error: Names the setting, what it must be, the value and the default.
    """
    for name, entry in declared(type(settings)).items():
        value = getattr(settings, name)
        if not entry.allows(value):
            raise error(f"{name} {entry.rule}, got {value!r}; the default is {entry.default!r}")
