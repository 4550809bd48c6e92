"""The pictures of the depth evaluation."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from bathbot_depthcorr.models.table import DEFAULT_MODEL, PAPERS_MODEL
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bathbot_bringup.evaluation.depth.methods.table import UNCORRECTED, all_methods
from bathbot_bringup.evaluation.depth.sweeps import SWEEPS, SWEPT
from bathbot_bringup.evaluation.depth.targets import DISTANCES

Array = NDArray[np.float64]

DATA_SHEET = 0.02  # relative error of depth that the data sheet allows
MAP_DISTANCES = (0.75, 1.5)  # [m]
MAPPED = (UNCORRECTED, PAPERS_MODEL, DEFAULT_MODEL)


def save_figures(
    folder: Path, summary: Mapping[str, Any], maps: Mapping[str, Mapping[float, Array]]
) -> list[Path]:
    """Draw all pictures.

    Args:
        folder: Where to; it must exist.
        summary: What `summarise` gave, with the rows of `table2`.
        maps: Signed errors of one unit [mm] by method and distance [m] of the wall.

    Returns:
        The files.
    """
    drawn = {
        "depth_error.png": _errors(summary),
        "depth_maps.png": _maps(maps),
        "depth_parts.png": _parts(summary, maps),
        "depth_table_2.png": _table_2(summary["table2"]),
    }
    if summary["sweeps_mm"]:
        drawn["depth_sweeps.png"] = _sweeps(summary["sweeps_mm"])
    paths = []
    for name, figure in drawn.items():
        FigureCanvasAgg(figure)
        figure.savefig(folder / name, dpi=110)
        paths.append(folder / name)
    return paths


def _colour(method: str) -> str:
    return all_methods()[method].colour


def _errors(summary: Mapping[str, Any]) -> Figure:
    """Systematic error against distance, absolute and signed."""
    figure = Figure(figsize=(12.0, 5.0), layout="constrained")
    absolute, signed = figure.subplots(1, 2)
    for method, row in summary["systematic_mm"].items():
        style = {"color": _colour(method), "marker": "o", "ms": 3, "lw": 2 if method in MAPPED else 1}
        absolute.plot(DISTANCES, list(row.values()), label=method, **style)
        bounds = np.array(list(summary["interval_mm"][method].values()), dtype=float)
        absolute.fill_between(DISTANCES, *bounds.T, color=_colour(method), alpha=0.12)
        signed.plot(DISTANCES, list(summary["signed_mm"][method].values()), **style)
    sheet = 1e3 * DATA_SHEET * np.array(DISTANCES)
    absolute.set(yscale="log", ylabel="mean absolute error [mm]", title="systematic error, 95 % interval")
    absolute.plot(DISTANCES, sheet, "--", color="red", lw=1, label="2 % of the data sheet")
    absolute.legend(fontsize="small", ncols=2)
    signed.plot(DISTANCES, sheet, "--", color="red", lw=1)
    signed.plot(DISTANCES, -sheet, "--", color="red", lw=1)
    signed.set(yscale="symlog", ylabel="mean signed error [mm]", title="signed error")
    signed.set_yscale("symlog", linthresh=1.0)
    for axes in (absolute, signed):
        axes.set_xlabel("distance of the wall [m]")
        axes.grid(visible=True, which="both", alpha=0.25)
    return figure


def _maps(maps: Mapping[str, Mapping[float, Array]]) -> Figure:
    """Where in the picture the error is, before and after."""
    figure = Figure(figsize=(12.0, 5.2), layout="constrained")
    grid = figure.subplots(len(MAP_DISTANCES), len(MAPPED))
    for row, distance in enumerate(MAP_DISTANCES):
        for column, method in enumerate(MAPPED):
            _map(figure, grid[row][column], maps[method][distance], f"{method}, {distance:.2f} m")
    figure.suptitle("signed error of a frontal wall [mm], one simulated unit")
    return figure


def _map(figure: Figure, axes: Axes, error: Array, title: str) -> None:
    known = error[np.isfinite(error)]
    centre = float(np.median(known)) if title.startswith(UNCORRECTED) else 0.0
    reach = max(0.2, float(np.percentile(np.abs(known - centre), 98.0)))
    image = axes.imshow(error, cmap="coolwarm", vmin=centre - reach, vmax=centre + reach)
    axes.set(xticks=[], yticks=[])
    axes.set_title(title, fontsize="small")
    figure.colorbar(image, ax=axes, shrink=0.85)


def _parts(summary: Mapping[str, Any], maps: Mapping[str, Mapping[float, Array]]) -> Figure:
    """Systematic, frozen and temporal error apart; and how many pixels err by how much."""
    figure = Figure(figsize=(12.0, 4.6), layout="constrained")
    bars, shares = figure.subplots(1, 2)
    methods = [method for method in summary["noise_rms_mm"] if method != UNCORRECTED]
    place, width = np.arange(len(methods)), 0.27
    for shift, part in enumerate(("systematic", "frozen", "temporal")):
        values = [summary["noise_rms_mm"][method][part] for method in methods]
        bars.bar(place + (shift - 1) * width, values, width, label=part)
    bars.set_xticks(place, methods, rotation=25, ha="right", fontsize="small")
    bars.set(ylabel="root mean square [mm]", title="a wall at 0.75 m: what the error is made of")
    bars.legend()
    for method, by_distance in maps.items():
        error = np.sort(np.abs(by_distance[MAP_DISTANCES[0]][np.isfinite(by_distance[MAP_DISTANCES[0]])]))
        shares.plot(error, np.linspace(0.0, 1.0, len(error)), color=_colour(method), label=method)
    shares.set(
        xscale="log", xlim=(0.01, 40.0), xlabel="systematic error [mm]", ylabel="share of pixels below",
        title=f"a wall at {MAP_DISTANCES[0]} m, one unit",
    )  # fmt: skip
    shares.grid(visible=True, which="both", alpha=0.25)
    shares.legend(fontsize="small")
    return figure


def _table_2(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """Table 2: published figures beside ours."""
    figure = Figure(figsize=(12.0, 4.2), layout="constrained")
    raw, corrected = figure.subplots(1, 2)
    place, width = np.arange(len(rows)), 0.27
    raw.bar(place - 0.5 * width, [row["published_raw_mm"] for row in rows], width, color="tab:gray")
    raw.bar(
        place + 0.5 * width, [row["raw_mm"] for row in rows], width, color="tab:blue",
        yerr=[row["raw_std_mm"] for row in rows], capsize=2,
    )  # fmt: skip
    raw.legend(["published", "simulated"])
    raw.set(title="before correction", ylabel="error of depth [mm]")
    kinds = [("published_z_mm", None, "published (Z error)", "tab:gray")]
    for column, method in ((PAPERS_MODEL, PAPERS_MODEL), ("corrected", DEFAULT_MODEL)):
        kinds.append((f"{column}_mm", f"{column}_std_mm", f"{method}, simulated", _colour(method)))
    for shift, (key, spread, label, colour) in enumerate(kinds):
        bars = [row[spread] for row in rows] if spread else None
        corrected.bar(
            place + (shift - 1) * width, [row[key] for row in rows], width, yerr=bars, capsize=2,
            color=colour, label=label,
        )  # fmt: skip
    corrected.set(title="after correction", ylabel="mean absolute error [mm]", ylim=(0.0, 2.0))
    corrected.legend(fontsize="small", loc="upper center", ncols=3)
    for axes in (raw, corrected):
        axes.set_xticks(place, [str(row["no"]) for row in rows])
        axes.set_xlabel("position of Table 2")
    return figure


def _sweeps(sweeps: Mapping[str, Sequence[Mapping[str, float]]]) -> Figure:
    """The error at working distances against each circumstance of a calibration."""
    figure = Figure(figsize=(13.0, 6.0), layout="constrained")
    grid = figure.subplots(2, 4).ravel()
    for axes, (name, rows) in zip(grid, sweeps.items(), strict=False):
        for method in SWEPT:
            places = [row["value"] for row in rows]
            axes.plot(
                places, [row[method] for row in rows], marker="o", ms=4, color=_colour(method), label=method
            )
        axes.set(xlabel=SWEEPS[name][0], ylabel="systematic error [mm]")
        axes.set_ylim(bottom=0.0)
        axes.grid(visible=True, alpha=0.25)
    for axes in grid[len(sweeps) :]:
        axes.set_axis_off()
    grid[0].legend(fontsize="small")
    figure.suptitle("systematic error at 0.62 to 0.88 m against the circumstances of the calibration")
    return figure
