"""Writes what was measured into the model card, so that no number there is typed by hand.

python -m bathbot_perception.model_card docs/model_card.md "real photos"=/data/photos:test ...
"""

import argparse
import time
from pathlib import Path

import numpy as np

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detector import DEFAULT_MODEL, load
from bathbot_perception.errors import PerceptionError, SettingsError
from bathbot_perception.evaluate import evaluate
from bathbot_perception.letterbox import fit_input, letterbox
from bathbot_perception.skin_detector_settings import SkinDetectorSettings

BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
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
        reports[title] = evaluate(folder, model, split=split, curves=picture)
    size = f"File: {model.name}, {model.stat().st_size / 1e6:.2f} MB."
    return "\n\n".join([accuracy_table(reports), timing_table(model), size])


def fill_card(card: Path, text: str) -> None:
    """Replace what stands between the two marks of the card."""
    content = card.read_text(encoding="utf-8")
    if content.count(BEGIN) != 1 or content.count(END) != 1:
        raise SettingsError(f"{card} must hold the lines {BEGIN} and {END} once each")
    before, rest = content.split(BEGIN)
    card.write_text(f"{before}{BEGIN}\n{text}\n{END}{rest.split(END)[1]}", encoding="utf-8")


def main() -> None:
    """Read the command line, measure, write."""
    parser = argparse.ArgumentParser(description="Measure a model and write the numbers into its card.")
    parser.add_argument("card", type=Path)
    parser.add_argument("data", nargs="+", metavar="TITLE=FOLDER[:SPLIT]")
    parser.add_argument("--model", type=Path, default=DEFAULT_MODEL)
    parser.add_argument("--curves", type=Path, help="folder for precision-recall pictures")
    given = parser.parse_args()
    data = {}
    for item in given.data:
        title, _, place = item.partition("=")
        folder, _, split = place.partition(":")
        data[title] = (Path(folder), split or "all")
    try:
        fill_card(given.card, measure(data, given.model, given.curves))
    except PerceptionError as error:
        raise SystemExit(f"error: {error}") from error


if __name__ == "__main__":
    main()
