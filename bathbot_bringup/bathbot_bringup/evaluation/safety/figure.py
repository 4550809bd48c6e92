"""The picture of the fault matrix: every trial's stop time, fault by fault."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bathbot_bringup.evaluation.safety.fault_table import FAULTS
from bathbot_bringup.evaluation.safety.trial_plan import DEADLINE, Phase
from bathbot_bringup.evaluation.safety.trial_result import TrialResult

COLOURS = {
    Phase.TRANSIT: "tab:gray", Phase.SEEK: "tab:blue", Phase.REST: "tab:green", Phase.SCRUB: "tab:orange",
}  # fmt: skip
_FARTHEST = 600.0  # [ms]; later ones are drawn here, as triangles


def save_figure(path: Path, trials: Sequence[TrialResult]) -> None:
    """Draw one dot per trial, coloured by what the arm was about, and the deadline.

    Args:
        path: PNG file to write.
        trials: Results.
    """
    names = [case.name for case in FAULTS if any(trial.fault == case.name for trial in trials)]
    figure = Figure(figsize=(9.0, 1.5 + 0.27 * len(names)), layout="constrained")
    axes = figure.subplots()
    for phase, colour in COLOURS.items():
        mine = [trial for trial in trials if trial.phase == phase.value]
        jitter = 0.08 * (np.arange(len(mine)) % 5 - 2)
        rows = np.array([names.index(trial.fault) for trial in mine]) + jitter
        stops = np.array([trial.stop_ms for trial in mine])
        late = stops > _FARTHEST
        axes.scatter(stops[~late], rows[~late], s=14, color=colour, alpha=0.7, label=phase.value)
        axes.scatter(np.full(late.sum(), _FARTHEST), rows[late], s=22, marker=">", color=colour)
    axes.axvline(1e3 * DEADLINE, color="tab:red", linewidth=1.0, label="deadline")
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set(
        xlim=(-10.0, _FARTHEST + 15.0),
        xlabel="fault to standing still or leaving [ms] (simulated); triangles: later or never",
    )
    axes.grid(axis="x", alpha=0.25)
    axes.legend(fontsize="small", loc="lower right")
    FigureCanvasAgg(figure)
    figure.savefig(path, dpi=110)
