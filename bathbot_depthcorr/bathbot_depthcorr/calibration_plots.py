"""The picture of a calibration: error against distance, and where in the image it was."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bathbot_depthcorr.calibrate import CalibrationReport, HeldOutView


def save_plots(report: CalibrationReport, path: Path | str) -> None:
    """Draw the held-out errors of a calibration to an image file."""
    figure = Figure(figsize=(11.0, 7.5), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(
        f"Depth correction {report.model}: {report.views} views, errors on {len(report.held_out)} held out"
    )
    grid = figure.add_gridspec(2, 2)
    _draw_distance(figure.add_subplot(grid[0, :]), report)
    middle = report.held_out[len(report.held_out) // 2]
    for column, name in enumerate(("before", "after")):
        _draw_residual(figure, figure.add_subplot(grid[1, column]), middle, name)
    figure.savefig(path, dpi=110)


def _draw_distance(axes: Axes, report: CalibrationReport) -> None:
    distance = np.array([view.distance for view in report.held_out])
    for name, marker in (("before", "s"), ("after", "o")):
        for kind, style in (("absolute", "-"), ("rmse", ":")):
            error = 1e3 * np.array([getattr(view, f"{kind}_{name}") for view in report.held_out])
            label = {"absolute": "mean absolute error", "rmse": "plane RMSE"}[kind]
            colour = "tab:red" if name == "before" else "tab:blue"
            axes.plot(distance, error, style, marker=marker, color=colour, label=f"{label}, {name}", ms=4)
    axes.set(xlabel="distance [m]", ylabel="error [mm]", yscale="log", title="error against distance")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(ncols=2, fontsize="small")


def _draw_residual(figure: Figure, axes: Axes, view: HeldOutView, name: str) -> None:
    residual = 1e3 * getattr(view, f"residual_{name}")
    known = residual[np.isfinite(residual)]
    centre = float(np.median(known)) if name == "before" else 0.0
    reach = max(0.2, float(np.percentile(np.abs(known - centre), 98.0)))
    image = axes.imshow(residual, cmap="coolwarm", vmin=centre - reach, vmax=centre + reach)
    axes.set(title=f"signed error {name} at {view.distance:.2f} m [mm]", xticks=[], yticks=[])
    figure.colorbar(image, ax=axes, shrink=0.85)
