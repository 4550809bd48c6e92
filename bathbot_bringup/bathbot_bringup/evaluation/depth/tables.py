"""The depth evaluation on the terminal."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from bathbot_depthcorr.models.table import DEFAULT_MODEL, PAPERS_MODEL
from rich.console import Console
from rich.table import Table

from bathbot_bringup.evaluation.depth.sweeps import SWEEPS, SWEPT
from bathbot_bringup.evaluation.depth.table_2 import PUBLISHED_CORRECTED, PUBLISHED_RAW
from bathbot_bringup.evaluation.depth.targets import DISTANCES

_MARKS = {"better": "", "level": " =", "worse": " !", "one unit": ""}


def print_summary(summary: Mapping[str, Any], console: Console) -> None:
    """Print what matters; the JSON file has the rest."""
    console.print(_systematic(summary))
    console.print(
        f"= the interval of the difference to {DEFAULT_MODEL} holds zero; ! {DEFAULT_MODEL} is worse",
        style="dim",
        markup=False,
    )
    console.print(_frames(summary))
    console.print(_table_2(summary))
    console.print(
        "one frame at 0.75 m, mean |e| in mm: "
        + ", ".join(f"{name} {value:.2f}" for name, value in summary["conditions_mm"].items()),
        markup=False,
    )
    for name, rows in summary["sweeps_mm"].items():
        console.print(_sweep(name, rows))


def _systematic(summary: Mapping[str, Any]) -> Table:
    title = f"systematic error in mm, {summary['units']} simulated units, preset {summary['preset']}"
    table = Table(
        "method", *(f"{z:.1f} m" for z in DISTANCES), "0.62-0.88 m", title=title, title_justify="left"
    )
    for method, row in summary["systematic_mm"].items():
        marks = summary["against"].get(method, {})
        cells = [f"{value:.2f}{_MARKS[marks[z]['ours_is']] if marks else ''}" for z, value in row.items()]
        table.add_row(method, *cells, f"{summary['working_mm'][method]:.3f}")
    return table


def _frames(summary: Mapping[str, Any]) -> Table:
    names = {
        "absolute": "mean |e| mm", "percentile_95": "95 % mm", "rmse": "plane RMSE mm",
        "subpixel_px": "sub-pixel px", "point": "point mm", "normal_deg": "normal deg",
    }  # fmt: skip
    table = Table(
        "method", *names.values(), "cylinder 40/160 mm", "extrinsics deg, mm", "fit s",
        title="one frame of a wall at 0.6 to 0.9 m, noise included", title_justify="left",
    )  # fmt: skip
    for method, row in summary["frames"].items():
        fit, cylinder = summary["fit"][method], summary["cylinder_mm"][method].values()
        table.add_row(
            method, *(f"{row[key]:.3f}" for key in names), " / ".join(f"{value:.2f}" for value in cylinder),
            f"{fit['extrinsics_deg']:.3f}, {fit['extrinsics_mm']:.2f}", f"{fit['seconds']:.1f}",
        )  # fmt: skip
    return table


def _table_2(summary: Mapping[str, Any]) -> Table:
    table = Table(
        "no.", "published raw", "simulated raw", "published Z error", PAPERS_MODEL, DEFAULT_MODEL,
        title="Table 2: published figures beside simulated trials, mean |e| ± spread in mm",
        title_justify="left",
    )  # fmt: skip
    rows = summary["table2"]
    for row in rows:
        table.add_row(
            str(row["no"]), f"{row['published_raw_mm']:.2f}",
            f"{row['raw_mm']:.2f} ± {row['raw_std_mm']:.2f}",
            f"{row['published_z_mm']:.2f}",
            f"{row[f'{PAPERS_MODEL}_mm']:.2f} ± {row[f'{PAPERS_MODEL}_std_mm']:.2f}",
            f"{row['corrected_mm']:.2f} ± {row['corrected_std_mm']:.2f}",
        )  # fmt: skip
    means = [np.mean([row[key] for row in rows]) for key in ("raw_mm", f"{PAPERS_MODEL}_mm", "corrected_mm")]
    table.add_section()
    table.add_row(
        "mean", f"{PUBLISHED_RAW:.3f}", f"{means[0]:.2f}", f"{PUBLISHED_CORRECTED:.3f}",
        *(f"{mean:.2f}" for mean in means[1:]),
    )  # fmt: skip
    return table


def _sweep(name: str, rows: Sequence[Mapping[str, float]]) -> Table:
    table = Table(
        SWEEPS[name][0], *(f"{row['value']:g}" for row in rows), title_justify="left",
        title="systematic error at 0.62 to 0.88 m in mm",
    )  # fmt: skip
    for method in SWEPT:
        table.add_row(method, *(f"{row[method]:.2f}" for row in rows))
    return table
