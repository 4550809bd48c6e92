"""A sweep as a table of peak forces, on the terminal and as Markdown."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from bathbot_bringup.evaluation.safety.sweep.sweep_case import Outcome
from bathbot_bringup.evaluation.safety.sweep.sweep_list import choose_sweep

_TOLD = 30  # lines of what was out of bounds on the terminal


def summarise(name: str, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """All numbers of a sweep: one entry a case."""
    cases: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        cases.setdefault(outcome.case, []).append(outcome)
    return {
        "simulated": True,
        "sweep": name,
        "trials": len(outcomes),
        "cases": [_case(found) for found in cases.values()],
    }


def _case(found: Sequence[Outcome]) -> dict[str, Any]:
    worst = max(found, key=lambda outcome: outcome.peak_n)
    return {
        "case": worst.case,
        "row": worst.row,
        "column": worst.column,
        "trials": len(found),
        "peak_n_p50": float(np.median([outcome.peak_n for outcome in found])),
        "peak_n_max": worst.peak_n,
        "bound_n": worst.bound_n,
        "too_hard": sum(outcome.peak_n > outcome.bound_n for outcome in found),
        "worst_seed": worst.seed,
        "said": worst.said,
    }


def out_of_bounds(summary: Mapping[str, Any]) -> list[str]:
    """Which cases met the body too hard, one line each; empty when none did."""
    return [
        f"{case['case']}: {case['peak_n_max']:.1f} N with seed {case['worst_seed']}, more than "
        f"{case['bound_n']:g} N; {case['too_hard']} of {case['trials']} trials"
        for case in summary["cases"]
        if case["too_hard"]
    ]


def _cells(summary: Mapping[str, Any]) -> tuple[list[str], dict[str, dict[str, tuple[str, bool]]]]:
    """Columns, and rows of texts with whether each is out of bounds."""
    known = dict.fromkeys(case.place[1] for case in choose_sweep(summary["sweep"]).cases())
    found = {case["column"] for case in summary["cases"]}
    columns = [column for column in known if column in found]
    rows: dict[str, dict[str, tuple[str, bool]]] = {}
    for case in summary["cases"]:
        cell = f"{case['peak_n_max']:.1f}", case["too_hard"] > 0
        rows.setdefault(case["row"], {})[case["column"]] = cell
    return columns, rows


def print_sweep(summary: Mapping[str, Any], console: Console) -> None:
    """Print the largest true force of each case [N]; what is out of bounds stands in red, and below."""
    sweep, (columns, rows) = choose_sweep(summary["sweep"]), _cells(summary)
    table = Table("", *columns, box=SIMPLE, pad_edge=False, title=f"largest force [N], by {sweep.columns}")
    for row, cells in rows.items():
        table.add_row(row, *(_red(*cells[column]) if column in cells else "" for column in columns))
    console.print(table)
    wrong = out_of_bounds(summary)
    for line in wrong[:_TOLD]:
        console.print(f"out of bounds: {line}", style="red", markup=False, soft_wrap=True)
    if len(wrong) > _TOLD:
        console.print(f"and {len(wrong) - _TOLD} cases more", style="red")


def _red(text: str, bad: bool) -> str:
    return f"[red]{text}![/red]" if bad else text


def markdown(summary: Mapping[str, Any]) -> str:
    """The same as a Markdown table."""
    sweep, (columns, rows) = choose_sweep(summary["sweep"]), _cells(summary)
    seeds, hard = len(summary["seeds"]), sum(case["too_hard"] for case in summary["cases"])
    lines = [
        f"`{summary['sweep']}`: {sweep.about}. {summary['trials']} trials in virtual time, {seeds} seeds a "
        f"case; {hard} out of bounds. Simulated. Largest true force [N], by {sweep.columns}; "
        "**bold** is too much.",
        "",
        f"| | {' | '.join(columns)} |",
        f"|---|{'---:|' * len(columns)}",
    ]
    for row, cells in rows.items():
        texts = (f"**{text}**" if bad else text for text, bad in (cells.get(c, ("", False)) for c in columns))
        lines.append(f"| {row} | {' | '.join(texts)} |")
    return "\n".join(lines) + "\n"
