"""The pictures of a report, as PNG files in memory."""

import io

import numpy as np
from bathbot_scrub.arm.force_limits import RegionLimits
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bathbot_bringup.report.coverage import Coverage
from bathbot_bringup.report.path_error import PathError
from bathbot_bringup.report.run_data import Run

Array = NDArray[np.float64]
PAPER_PATH_ERROR, PAPER_TARGET_ERROR = 2.23, 2.186  # [mm] largest y-deviation; mean error of Table 2
_BLUE, _ORANGE, _GREEN, _RED = "#0072b2", "#e69f00", "#009e73", "#d55e00"


def _figure() -> tuple[Figure, object]:
    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    axes = figure.add_subplot()
    axes.grid(alpha=0.3)
    return figure, axes


def png(figure: Figure) -> bytes:
    """Draw a figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()


def draw_targets(times: Array, errors: Array, used: float | None) -> Figure:
    """Localisation error of every target over time.

    Args:
        times: Since the beginning of the run [s], shape (T,).
        errors: Found minus true position [m] in the base frame, shape (T, 3).
        used: Time of the target that was approached [s]; None when there was none.
    """
    figure, axes = _figure()
    for axis, name, colour in zip(range(3), "xyz", (_BLUE, _ORANGE, _GREEN), strict=True):
        axes.plot(times, 1000.0 * errors[:, axis], ".", ms=3, color=colour, label=name)
    axes.plot(times, 1000.0 * np.linalg.norm(errors, axis=1), "k.", ms=4, label="distance")
    axes.axhline(
        PAPER_TARGET_ERROR, color="grey", ls=":", label=f"mean of the paper, {PAPER_TARGET_ERROR} mm"
    )
    if used is not None:
        axes.axvline(used, color=_RED, lw=1, label="the target approached")
    axes.set(xlabel="time [s]", ylabel="found - true [mm]", title="Localisation error of the contact target")
    axes.legend(ncols=3, fontsize=8)
    return figure


def draw_path_error(error: PathError) -> Figure:
    """Deviation from the planned path, at each of its poses."""
    figure, axes = _figure()
    axes.plot(
        error.distance, 1000.0 * error.across, color=_BLUE, lw=1, label="across the travel, along the skin"
    )
    axes.plot(error.distance, 1000.0 * error.depth, color=_ORANGE, lw=1, label="into the skin")
    for side in (-1, 1):
        label = f"largest of the paper, {PAPER_PATH_ERROR} mm" if side > 0 else None
        axes.axhline(side * PAPER_PATH_ERROR, color="grey", ls=":", label=label)
    axes.set(
        xlabel="along the planned path [m]", ylabel="actual - planned [mm]", title="Path error every 2 mm"
    )
    axes.legend(fontsize=8)
    return figure


def draw_force(run: Run, epoch: float, limits: RegionLimits, threshold: float) -> Figure:
    """True and measured force over time, with the region's comfort band and the threshold."""
    figure, axes = _figure()
    least, most = limits.comfort
    axes.axhspan(least, most, color=_GREEN, alpha=0.12, label=f"comfort band {least:g}-{most:g} N")
    axes.plot(run.contacts.time - epoch, run.contacts.force, color=_BLUE, lw=0.8, label="true (simulated)")
    axes.plot(run.arm.time - epoch, run.arm.force, color=_ORANGE, lw=0.8, label="measured and filtered")
    if np.isfinite(threshold):
        axes.axhline(threshold, color=_RED, lw=1, label=f"the arm retracts at {threshold:.0f} N")
    touching = run.contacts.time[run.contacts.force > 0.1] - epoch
    if len(touching):
        axes.set_xlim(touching[0] - 2.0, touching[-1] + 2.0)
    axes.set(xlabel="time [s]", ylabel="force [N]", ylim=(-0.2, None), title="Force on the scrub head")
    axes.legend(fontsize=8, loc="upper right")
    return figure


def draw_coverage(coverage: Coverage, path: Array) -> Figure:
    """The patch of skin, what came under the brush and the planned path.

    Args:
        coverage: Samples of the patch.
        path: Planned path in the same plane [m], shape (M, 2).
    """
    figure = Figure(figsize=(5.6, 5.0), layout="constrained")
    axes = figure.add_subplot(aspect="equal")
    missed = ~coverage.covered
    for chosen, colour, label in ((coverage.covered, _GREEN, "under the brush"), (missed, _RED, "missed")):
        axes.plot(*(1000.0 * coverage.samples[chosen].T), ".", ms=3, color=colour, alpha=0.6, label=label)
    axes.plot(*(1000.0 * path.T), "k-", lw=1, label="planned path")
    axes.set(xlabel="along the patch [mm]", ylabel="up the patch [mm]", title="Skin of the planned patch")
    axes.legend(fontsize=8, loc="upper right")
    return figure
