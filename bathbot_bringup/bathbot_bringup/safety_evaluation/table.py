"""The fault matrix on the terminal and as Markdown."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from bathbot_bringup.safety_evaluation.fault_table import DEADLINE, FAULTS
from bathbot_bringup.safety_evaluation.summary import RETRACT_MAX, RETRACT_P99, out_of_bounds

_COLUMNS = ("trials", "missed", "detected", "stop p50", "p95", "max", "force", "travel")
_UNITS = ("", "", "ms", "ms", "ms", "ms", "N", "mm")


def print_matrix(summary: Mapping[str, Any], console: Console) -> None:
    """Print one row per fault; what is out of bounds stands in red, and below in words."""
    table = Table(
        "fault", *(f"{name}\n{unit}" for name, unit in zip(_COLUMNS, _UNITS, strict=True)),
        title="faults and the arm's reaction (simulated)", box=SIMPLE, pad_edge=False,
    )  # fmt: skip
    for column in table.columns:
        column.no_wrap = True
    for row in summary["faults"]:
        table.add_row(row["name"], *(_marked(cell, bad) for cell, bad in _cells(row)))
    console.print(table)
    console.print(retract_line(summary), markup=False)
    for line in out_of_bounds(summary):
        console.print(f"out of bounds: {line}", style="red", markup=False, soft_wrap=True)


def _marked(cell: str, bad: bool) -> str:
    return f"[red]{cell}![/red]" if bad else cell


def _cells(row: Mapping[str, Any]) -> Sequence[tuple[str, bool]]:
    """Texts of a row, and whether each is out of bounds."""
    late = 1e3 * DEADLINE
    return (
        (str(row["trials"]), False),
        (str(row["missed"]), row["missed"] > 0),
        (f"{_whole(row['detect_ms_p50'])}", False),
        (_whole(row["stop_ms_p50"]), row["stop_ms_p50"] > late),
        (_whole(row["stop_ms_p95"]), row["stop_ms_p95"] > late),
        (_whole(row["stop_ms_max"]), row["stop_ms_max"] > late),
        (f"{row['overshoot_n_max']:.1f}", row["too_hard"] > 0),
        (f"{row['travel_mm_max']:.1f}", False),
    )


def _whole(value: float) -> str:
    return f"{value:.0f}" if np.isfinite(value) else "never"


def retract_line(summary: Mapping[str, Any]) -> str:
    """The times from force to retract in one line."""
    if not summary["retracts"]:
        return "force over its threshold -> first retract command: the force never passed it"
    times = {key: summary[f"retract_ms_{key}"] for key in ("p50", "p99", "max")}
    return (
        f"force over its threshold -> first retract command: p50 {times['p50']:.1f} ms, "
        f"p99 {times['p99']:.1f} ms (at most {RETRACT_P99:g}), max {times['max']:.1f} ms "
        f"(at most {RETRACT_MAX:g}), {summary['retracts']} retracts"
    )


def markdown(summary: Mapping[str, Any]) -> str:
    """The same as a Markdown table, with what each fault is."""
    about = {case.name: case.about for case in FAULTS}
    here, minutes = summary["machine"], summary["seconds"] / 60.0
    units = (f" [{unit}]" if unit else "" for unit in _UNITS)
    head = ("fault", "what happens", *(name + unit for name, unit in zip(_COLUMNS, units, strict=True)))
    lines = [
        f"{summary['trials']} trials in {minutes:.0f} min, {summary['jobs']} graphs at a time, on "
        f"{here['cores']} cores ({here['cpu']}), load {here['load']:.1f} at the start. "
        "Simulated. **Bold** is out of bounds; `detected` is a median.",
        "",
        f"| {' | '.join(head)} |",
        f"|---|---|{'---:|' * len(_COLUMNS)}",
    ]
    for row in summary["faults"]:
        cells = (f"**{cell}**" if bad else cell for cell, bad in _cells(row))
        lines.append(f"| {row['name']} | {about[row['name']]} | {' | '.join(cells)} |")
    lines += ["", retract_line(summary) + "."]
    return "\n".join(lines) + "\n"
