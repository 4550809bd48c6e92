"""Summaries for a person: one run, and many."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

# Key of the summary, what it means, unit, digits.
ROWS = (
    ("localization_error_mm", "localisation error against the truth", "mm", 2),
    ("path_y_error_max_mm", "path error across the travel, largest", "mm", 2),
    ("path_y_error_mean_mm", "path error across the travel, mean", "mm", 2),
    ("contact_fraction", "planned path scrubbed in contact", "%", 1),
    ("coverage", "planned patch under the brush", "%", 1),
    ("force_mean_n", "force on the path, mean", "N", 2),
    ("force_peak_n", "force, peak", "N", 2),
    ("force_threshold_n", "force that makes the arm retract", "N", 1),
    ("comfort_fraction", "time on the path within the comfort band", "%", 1),
    ("command_period_p99_dev_ms", "command period, p99 of its deviation", "ms", 2),
    ("messages_lost", "messages that the recording lacks", "", 0),
    ("path_length_m", "planned path", "m", 3),
    ("duration_s", "whole run", "s", 1),
)


def _shown(value: float | None, unit: str, digits: int) -> str:
    if value is None or not np.isfinite(value):
        return "-"
    return f"{100.0 * value if unit == '%' else value:.{digits}f} {unit}".rstrip()


def table_rows(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Give the measures of one run in words: what, and its value with unit."""
    return [(about, _shown(summary.get(key), unit, digits)) for key, about, unit, digits in ROWS]


def print_summary(console: Console, summary: Mapping[str, Any]) -> None:
    """Print one run."""
    state = "done" if summary["done"] else "NOT DONE"
    table = Table(
        title=f"{summary['region']}, seed {summary['seed']}: {state} (simulated)", title_justify="left"
    )
    table.add_column("measure")
    table.add_column("value", justify="right")
    for about, value in table_rows(summary):
        table.add_row(about, value)
    console.print(table)


def spread(summaries: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    """Sum up numbers over runs: count, mean, standard deviation, least and largest of each key."""
    result = {}
    for key, *_ in ROWS:
        values = np.array(
            [summary[key] for summary in summaries if summary.get(key) is not None], dtype=float
        )
        if len(values):
            result[key] = {
                "count": len(values), "mean": float(values.mean()), "std": float(values.std()),
                "min": float(values.min()), "max": float(values.max()),
            }  # fmt: skip
    return result


def print_spread(console: Console, summaries: Sequence[Mapping[str, Any]]) -> None:
    """Print many runs: one column each for mean, spread and extremes."""
    done = sum(bool(summary["done"]) for summary in summaries)
    table = Table(title=f"{done} of {len(summaries)} jobs done (simulated)", title_justify="left")
    table.add_column("measure")
    for heading in ("mean", "std", "min", "max"):
        table.add_column(heading, justify="right")
    numbers = spread(summaries)
    for key, about, unit, digits in ROWS:
        if key in numbers:
            table.add_row(
                about, *(_shown(numbers[key][name], unit, digits) for name in ("mean", "std", "min", "max"))
            )
    console.print(table)
    for summary in summaries:
        if not summary["done"]:
            console.print(
                f"seed {summary['seed']}: {summary['failure']}", markup=False, highlight=False, soft_wrap=True
            )
