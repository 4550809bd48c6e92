"""The sweeps there are, and which of their cases are meant."""

from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from typing import NamedTuple

from bathbot_bringup.errors import InputError
from bathbot_bringup.evaluation.safety.sweep.leans import leans
from bathbot_bringup.evaluation.safety.sweep.paths import paths
from bathbot_bringup.evaluation.safety.sweep.pushes import pushes
from bathbot_bringup.evaluation.safety.sweep.sweep_case import SweepCase


class Sweep(NamedTuple):
    """One sweep."""

    about: str  # its cases
    columns: str  # what stands above the columns of its table
    cases: Callable[[], list[SweepCase]]


SWEEPS = {
    "pushes": Sweep("the body comes against the brush by 60 mm", "speed of the body [mm/s]", pushes),
    "leans": Sweep("the person leans by so many mm into the way that was planned; seen: 5 clouds a second, "
                   "0.2 s late; blind: none",
                   "speed of the body [mm/s]; there: before the arm sets out", leans),
    "paths": Sweep("a path sinks into the body", "depth at its end [mm]", paths),
}  # fmt: skip


def choose_sweep(name: str) -> Sweep:
    """A sweep by name.

    Raises:
        InputError: When there is none; the message lists them.
    """
    if name not in SWEEPS:
        raise InputError(f"no sweep is named {name!r}; there are {', '.join(SWEEPS)}")
    return SWEEPS[name]


def choose_cases(name: str, patterns: Sequence[str] = ()) -> list[SweepCase]:
    """Cases of a sweep by name, where * stands for anything; all of them when none is named.

    Raises:
        InputError: On an unknown sweep, or a pattern that fits no case.
    """
    cases = choose_sweep(name).cases()
    for pattern in patterns:
        if not any(fnmatchcase(case.name, pattern) for case in cases):
            raise InputError(f"no case of {name} is named {pattern!r}; one is {cases[0].name}, * fits all")
    return [case for case in cases if not patterns or any(fnmatchcase(case.name, p) for p in patterns)]
