"""Writes what was measured into the model card, so that no number there is typed by hand.

python -m bathbot_perception.model_card docs/model_card.md "real photos"=/data/photos:test ...
"""

import argparse
import csv
import os
import time
from pathlib import Path

import numpy as np

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detector import DEFAULT_MODEL, load
from bathbot_perception.errors import PerceptionError, SettingsError
from bathbot_perception.evaluate import evaluate
from bathbot_perception.letterbox import fit_input, letterbox
from bathbot_perception.skin_detector_settings import SkinDetectorSettings

TIMED_PICTURE = (480, 848)
"""Height and width of the picture that timing uses [px], a D455 colour stream."""


def accuracy_table(reports: dict[str, dict]) -> str:
    """MAP and AP per class of several reports of `evaluate`, as Markdown."""
    head = ["data", "pictures", "mAP50", "mAP50-95", *(name.removesuffix("_skin") for name in SKIN_CLASSES)]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for title, report in reports.items():
        classes = ["-" if value is None else f"{value:.3f}" for value in report["ap50"].values()]
        cells = [
            title,
            str(report["images"]),
            f"{report['map50']:.3f}",
            f"{report['map50_95']:.3f}",
            *classes,
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def timing_table(model: Path, rounds: int = 60) -> str:
    """Median and 95th percentile of `Detector.detect` on noise, with one and two threads, as Markdown."""
    picture = np.random.default_rng(0).integers(0, 256, (*TIMED_PICTURE, 3), dtype=np.uint8)
    lines = ["| threads | input | median ms | 95 % ms | pictures/s |", "|---|---|---|---|---|"]
    for threads in (1, 2):
        detector = load(model, SkinDetectorSettings(threads=threads))
        durations = []
        for _ in range(rounds + 5):
            begun = time.perf_counter()
            detector.detect(picture)
            durations.append(1e3 * (time.perf_counter() - begun))
        middle, late = np.percentile(durations[5:], [50, 95])
        shape = letterbox(picture, fit_input(TIMED_PICTURE, detector.size)).shape
        lines.append(
            f"| {threads} | {shape[3]}x{shape[2]} | {middle:.1f} | {late:.1f} | {1e3 / middle:.1f} |"
        )
    lines += ["", f"Load of the machine (1-minute mean) when this was timed: {os.getloadavg()[0]:.1f}."]
    return "\n".join(lines)


def measure(data: dict[str, tuple[Path, str]], model: Path, curves: Path | None) -> str:
    """All measured tables.

    Args:
        data: Title -> (data set folder, split), see `evaluate`.
        model: ONNX file.
        curves: Folder for precision-recall pictures, or None.
    """
    reports = {}
    for title, (folder, split) in data.items():
        picture = curves / f"pr_{title.replace(' ', '_').replace(',', '')}.png" if curves else None
        reports[title] = evaluate(folder, model, split=split, curves=picture, conditions=())
    size = f"File: {model.name}, {model.stat().st_size / 1e6:.2f} MB."
    return "\n\n".join([accuracy_table(reports), timing_table(model), size])


def training_summary(run: Path) -> str:
    """Length and speed of a training run, from its `training.csv`.

    Raises:
        SettingsError: If the file is missing or empty.
    """
    log = run / "training.csv"
    if not log.is_file():
        raise SettingsError(f"there is no {log}; name the folder that training wrote to")
    with log.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise SettingsError(f"{log} is empty; has training begun?")
    speeds = np.array([float(row["images_per_s"]) for row in rows])
    minutes, median = float(rows[-1]["minutes"]), np.median(speeds)
    return (
        f"{rows[-1]['step']} steps in {minutes:.0f} minutes of training; {median:.1f} pictures/s in the "
        f"median, {speeds.min():.1f} to {speeds.max():.1f} because other programs ran beside it."
    )


def marks(part: str) -> tuple[str, str]:
    """The lines round a part of the card."""
    return f"<!-- {part}: begin -->", f"<!-- {part}: end -->"


def fill_card(card: Path, part: str, text: str) -> None:
    """Replace what stands between the two marks of a part.

    Raises:
        SettingsError: If the marks are not there once each.
    """
    content = card.read_text(encoding="utf-8")
    begin, end = marks(part)
    if content.count(begin) != 1 or content.count(end) != 1:
        raise SettingsError(f"{card} must hold the lines {begin} and {end} once each")
    before, rest = content.split(begin)
    card.write_text(f"{before}{begin}\n{text}\n{end}{rest.split(end)[1]}", encoding="utf-8")


def main() -> None:
    """Read the command line, measure, write."""
    parser = argparse.ArgumentParser(description="Measure a model and write the numbers into its card.")
    parser.add_argument("card", type=Path)
    parser.add_argument("data", nargs="*", metavar="TITLE=FOLDER[:SPLIT]")
    parser.add_argument("--run", type=Path, help="folder of the training run")
    parser.add_argument("--model", type=Path, default=DEFAULT_MODEL)
    parser.add_argument("--curves", type=Path, help="folder for precision-recall pictures")
    given = parser.parse_args()
    data = {}
    for item in given.data:
        title, _, place = item.partition("=")
        folder, _, split = place.partition(":")
        data[title] = (Path(folder), split or "all")
    try:
        if given.run is not None:
            fill_card(given.card, "training", training_summary(given.run))
        if data:
            fill_card(given.card, "measured", measure(data, given.model, given.curves))
    except PerceptionError as error:
        raise SystemExit(f"error: {error}") from error


if __name__ == "__main__":
    main()
