"""The picture of a calibration: errors against distance, in the image and over all pixels; references."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bathbot_depthcorr.calibration.held_out_view import HeldOutView
from bathbot_depthcorr.calibration.report import CalibrationReport
from bathbot_depthcorr.models.wall_fit import PRIOR_ROTATION, PRIOR_TRANSLATION

DATA_SHEET = 0.02  # of the distance, that an uncorrected D455 may err
COLOURS = {"before": "tab:red", "after": "tab:blue"}
_SHOWN = (0.75, 1.5)  # [m] distances of which the nearest views are shown


def save_plots(report: CalibrationReport, path: Path | str) -> None:
    """Draw the held-out errors of a calibration, and its references, to an image file."""
    figure = Figure(figsize=(15.0, 9.5), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(
        f"Depth correction {report.model}: {report.views} views, errors on {len(report.held_out)} held out, "
        f"mean {report.before * 1e3:.2f} -> {report.after * 1e3:.2f} mm"
    )
    grid = figure.add_gridspec(3, 4)
    _draw_signed(figure.add_subplot(grid[0, :2]), report)
    _draw_size(figure.add_subplot(grid[0, 2:]), report)
    for column, distance in zip((0, 2), _SHOWN, strict=True):
        view = min(report.held_out, key=lambda view: abs(view.distance - distance))
        for shift, name in enumerate(COLOURS):
            _draw_residual(figure, figure.add_subplot(grid[1, column + shift]), view, name)
    _draw_extrinsics(figure.add_subplot(grid[2, 0]), report.change[:3], PRIOR_ROTATION, "turn")
    _draw_extrinsics(figure.add_subplot(grid[2, 1]), report.change[3:], PRIOR_TRANSLATION, "move")
    _draw_learning(figure.add_subplot(grid[2, 2]), report)
    _draw_shares(figure.add_subplot(grid[2, 3]), report)
    figure.savefig(path, dpi=110)


def _draw_signed(axes: Axes, report: CalibrationReport) -> None:
    distance = np.array([view.distance for view in report.held_out])
    for name, marker in (("before", "s"), ("after", "o")):
        error = 1e3 * np.array([getattr(view, f"signed_{name}") for view in report.held_out])
        axes.plot(distance, error, "-", marker=marker, color=COLOURS[name], label=name, ms=4)
    reach = np.array([0.0, 1.05 * distance.max()])
    for sign in (-1.0, 1.0):
        label = f"data sheet, {DATA_SHEET:.0%}" if sign > 0.0 else None
        axes.plot(reach, sign * 1e3 * DATA_SHEET * reach, "--", color="grey", label=label)
    axes.set(
        xlabel="distance [m]", ylabel="mean signed error [mm]", title="signed error against distance",
        xlim=(0.9 * distance.min(), reach[1]),
    )  # fmt: skip
    axes.grid(visible=True, alpha=0.3)
    axes.legend(fontsize="small")


def _draw_size(axes: Axes, report: CalibrationReport) -> None:
    distance = np.array([view.distance for view in report.held_out])
    for name, marker in (("before", "s"), ("after", "o")):
        for kind, style in (("absolute", "-"), ("rmse", ":")):
            error = 1e3 * np.array([getattr(view, f"{kind}_{name}") for view in report.held_out])
            label = {"absolute": "mean absolute error", "rmse": "plane RMSE"}[kind]
            axes.plot(
                distance, error, style, marker=marker, color=COLOURS[name], label=f"{label}, {name}", ms=4
            )
    axes.set(xlabel="distance [m]", ylabel="error [mm]", yscale="log", title="size of the error")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(ncols=2, fontsize="small")


def _draw_residual(figure: Figure, axes: Axes, view: HeldOutView, name: str) -> None:
    residual = 1e3 * getattr(view, f"residual_{name}")
    known = residual[np.isfinite(residual)]
    centre = float(np.median(known)) if name == "before" else 0.0
    reach = max(0.2, float(np.percentile(np.abs(known - centre), 98.0)))
    image = axes.imshow(residual, cmap="coolwarm", vmin=centre - reach, vmax=centre + reach)
    axes.set(title=f"signed error {name} at {view.distance:.2f} m [mm]", xticks=[], yticks=[])
    figure.colorbar(image, ax=axes, shrink=0.7)


def _draw_extrinsics(axes: Axes, change: np.ndarray, prior: float, kind: str) -> None:
    """Three dots against bands of one and two standard deviations of the factory's numbers."""
    unit, factor = ("deg", np.rad2deg(1.0)) if kind == "turn" else ("mm", 1e3)
    for width, alpha in ((2.0, 0.12), (1.0, 0.2)):
        axes.axvspan(-width * factor * prior, width * factor * prior, color="tab:green", alpha=alpha)
    axes.plot(factor * change, [2, 1, 0], "o", color="tab:blue")
    axes.axvline(0.0, color="grey", lw=0.8)
    axes.set(
        yticks=[2, 1, 0], yticklabels=["x", "y", "z"], ylim=(-0.6, 2.6), xlabel=f"{kind} [{unit}]",
        title=f"depth -> colour against factory: {kind}",
    )  # fmt: skip


def _draw_learning(axes: Axes, report: CalibrationReport) -> None:
    views = [point.views for point in report.learning]
    axes.plot(views, [1e3 * point.error for point in report.learning], "o-", color=COLOURS["after"])
    axes.set(
        xlabel="views learnt from",
        ylabel="held-out error of patches [mm]",
        title="learning curve",
        ylim=(0.0, None),
    )
    axes.grid(visible=True, alpha=0.3)


def _draw_shares(axes: Axes, report: CalibrationReport) -> None:
    for name, colour in COLOURS.items():
        sizes = np.sort(np.concatenate([getattr(view, f"quantiles_{name}") for view in report.held_out]))
        shares = np.linspace(0.0, 1.0, len(sizes))
        axes.plot(1e3 * sizes, shares, color=colour, label=name)
    axes.set(
        xscale="log", xlabel="absolute error of a pixel [mm]", ylabel="share of pixels", ylim=(0.0, 1.0),
        title="how many pixels err less", xlim=(0.01, None),
    )  # fmt: skip
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(fontsize="small")
