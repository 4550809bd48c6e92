r"""Writes what was measured into the model card, so that no number there is typed by hand.

python -m bathbot_perception.evaluation.model_card docs/model_card.md \\
    "real photos"=/data/photos:test ... --show renders
"""

import argparse
import csv
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.progress import track

from bathbot_perception.detection.detector import MODELS, load
from bathbot_perception.detection.settings import SkinDetectorSettings
from bathbot_perception.errors import PerceptionError, SettingsError
from bathbot_perception.evaluation.card_pictures import condition_sheet, failure_sheet
from bathbot_perception.evaluation.card_tables import (
    Report,
    accuracy_table,
    condition_table,
    confusion_table,
    time_table,
    tone_table,
)
from bathbot_perception.evaluation.conditions import CONDITIONS
from bathbot_perception.evaluation.evaluate import choose_samples, evaluate

_FLOAT, _INT8 = MODELS / "skin.onnx", MODELS / "skin_int8.onnx"
Data = dict[str, tuple[Path, str]]
"""Title -> (data set folder, split), see `evaluate`."""


def measure(data: Data, curves: Path | None) -> dict[str, str]:
    """The measured parts of the card: float model, INT8 model, conditions, tones, confusion."""
    reports: dict[str, Report] = {}
    for title, (folder, split) in track(data.items(), "data sets"):
        for model, conditions in ((_FLOAT, tuple(CONDITIONS)), (_INT8, ())):
            name = title if model == _FLOAT else f"{title}, INT8"
            picture = curves / f"pr_{_file_name(title)}.png" if curves and conditions else None
            reports[name] = evaluate(folder, model, split=split, curves=picture, conditions=conditions)
    sizes = ", ".join(f"{file.name} {file.stat().st_size / 1e6:.2f} MB" for file in (_FLOAT, _INT8))
    confusions = [
        f"{title}:\n\n{confusion_table(report)}" for title, report in reports.items() if report["conditions"]
    ]
    return {
        "measured": "\n\n".join([accuracy_table(reports), f"Files: {sizes}."]),
        "conditions": condition_table(reports),
        "tones": tone_table(reports),
        "confusion": "\n\n".join(confusions),
    }


def _file_name(title: str) -> str:
    return "_".join(title.replace(",", " ").split())


def draw_pictures(folder: Path, pictures: Path) -> None:
    """Sheets of conditions and of failures, from a data set whose pictures may be shown."""
    samples = choose_samples(folder, "all")
    detector = load(_FLOAT, replace(SkinDetectorSettings(), threads=2))
    condition_sheet(detector, samples[len(samples) // 2], pictures / "detector_conditions.jpg")
    failure_sheet(detector, samples, pictures / "detector_failures.jpg")


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
        f"median, {speeds.min():.1f} to {speeds.max():.1f}."
    )


def read_benches(files: Sequence[Path]) -> list[Report]:
    """What `bathbot bench detector --json` wrote.

    Raises:
        SettingsError: If a file is none of its.
    """
    benches = []
    for file in files:
        try:
            bench = json.loads(file.read_text(encoding="utf-8"))
            time_table([bench])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise SettingsError(f"{file} is not from `bathbot bench detector --json`: {error!r}") from error
        benches.append(bench)
    return benches


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
    parser = argparse.ArgumentParser(description="Measure the models and write the numbers into their card.")
    parser.add_argument("card", type=Path)
    parser.add_argument("data", nargs="*", metavar="TITLE=FOLDER[:SPLIT]")
    parser.add_argument("--run", type=Path, help="folder of the training run")
    parser.add_argument("--curves", type=Path, help="folder for precision-recall pictures")
    parser.add_argument("--bench", type=Path, nargs="*", help="JSON files of `bathbot bench detector`")
    parser.add_argument("--show", type=Path, help="data set whose pictures may be shown, such as renders")
    parser.add_argument("--pictures", type=Path, help="folder for the sheets made of it")
    given = parser.parse_args()
    data: Data = {}
    for item in given.data:
        title, _, place = item.partition("=")
        folder, _, split = place.partition(":")
        data[title] = (Path(folder), split or "all")
    try:
        if given.run is not None:
            fill_card(given.card, "training", training_summary(given.run))
        if given.bench:
            fill_card(given.card, "times", time_table(read_benches(given.bench)))
        if given.show and given.pictures:
            draw_pictures(given.show, given.pictures)
        for part, text in measure(data, given.curves).items() if data else ():
            fill_card(given.card, part, text)
    except PerceptionError as error:
        raise SystemExit(f"error: {error}") from error


if __name__ == "__main__":
    main()
