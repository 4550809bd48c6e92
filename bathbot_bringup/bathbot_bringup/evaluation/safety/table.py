"""The fault matrix on the terminal and as Markdown."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from bathbot_bringup.evaluation.safety.fault_table import FAULTS
from bathbot_bringup.evaluation.safety.summary import RETRACT_MAX, RETRACT_P99, out_of_bounds

_COLUMNS = (  # on the terminal, in Markdown
    ("n", "trials"),
    ("missed", "missed"),
    ("seen\nms", "detected [ms]"),
    ("p50\nms", "stopped p50 [ms]"),
    ("p95\nms", "p95 [ms]"),
    ("max\nms", "max [ms]"),
    ("force\nN", "peak force [N]"),
    ("way\nmm", "travel [mm]"),
)


def print_matrix(summary: Mapping[str, Any], console: Console) -> None:
    """Print one row per fault; what is out of bounds stands in red, and below in words."""
    table = Table(
        "fault", *(short for short, _ in _COLUMNS), box=SIMPLE, pad_edge=False,
        title="faults, and the time to standing still or leaving (simulated)",
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
    late = row["deadline_ms"]
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
    return f"{value:.0f}" if np.isfinite(value) else "inf"


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
    head = ("fault", "what happens", *(name for _, name in _COLUMNS))
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
