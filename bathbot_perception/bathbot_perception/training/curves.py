"""The course of a training run as a picture, from its CSV files."""

import csv
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

_LOSSES = ("box", "objectness", "class")


def draw_curves(out: Path) -> None:
    """Draw losses, speed and mAP50 over minutes of training to `curves.png` in a run's folder.

    Args:
        out: With `training.csv` and `validation.csv`; what is missing is left out.
    """
    figure = Figure(figsize=(10.0, 7.0), layout="constrained")
    losses, speed, precision, classes = figure.subplots(2, 2, sharex=True).flat
    training, validation = _rows(out / "training.csv"), _rows(out / "validation.csv")
    for name in _LOSSES:
        _draw(losses, training, name)
    losses.set(title="losses", yscale="log")
    _draw(speed, training, "images_per_s")
    speed.set(title="images per second", ylim=(0, None))
    for data in dict.fromkeys(row["data"] for row in validation):
        mine = [row for row in validation if row["data"] == data]
        _draw(precision, mine, "map50", data)
        if data == validation[0]["data"]:
            for name in (key for key in mine[0] if key.endswith("_skin")):
                _draw(classes, mine, name)
            classes.set(title=f"AP50, {data}")
    precision.set(title="mAP50")
    for axes in (losses, precision, classes):
        if axes.get_legend_handles_labels()[0]:
            axes.legend(fontsize="small")
    for axes in (precision, classes):
        axes.set(xlabel="minutes of training", ylim=(0, 1))
    for axes in (losses, speed, precision, classes):
        axes.grid(alpha=0.3)
    figure.savefig(out / "curves.png", dpi=110)


def _rows(path: Path) -> list[dict[str, str]]:
    if not path.is_file():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _draw(axes: Axes, rows: list[dict[str, str]], name: str, label: str = "") -> None:
    axes.plot(
        [float(row["minutes"]) for row in rows], [float(row[name]) for row in rows], label=label or name
    )
