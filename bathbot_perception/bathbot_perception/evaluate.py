"""How well a model finds the boxes of a data set: numbers for a report and curves for a picture."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from bathbot_perception.average_precision import (
    THRESHOLDS,
    PictureResult,
    average_precision,
    mean_average_precision,
    precision_recall,
)
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detector import Detector, load
from bathbot_perception.errors import SettingsError
from bathbot_perception.pictures import read_picture
from bathbot_perception.skin_detector_settings import SkinDetectorSettings
from bathbot_perception.splits import split_samples
from bathbot_perception.voc import Sample, list_samples, read_annotation, read_checked

LEAST_SCORE = 0.01
"""Detections down to this score enter the curves."""
SPLITS = ("all", "checked", "train", "val", "test")


def evaluate(
    dataset: Path,
    model: Path | str | None = None,
    settings: SkinDetectorSettings | None = None,
    split: str = "all",
    curves: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, object]:
    """Run a model over a PASCAL VOC data set.

    Args:
        dataset: Folder with `images/` and `annotations/`.
        model: ONNX file; without it the one of the settings or of the package.
        settings: Provider, threads, size and overlap limit; score and count limits do not apply.
        split: Which pictures: one of `SPLITS`; see `splits.split_samples`.
        curves: PNG file to draw the precision-recall curves to.
        progress: Called with (pictures done, pictures in all).

    Returns:
        `map50`, `map50_95`, `ap50` per class (None where a class does not occur), `images`,
        `boxes` per class, `ms_per_image_p50`, `size_px`, `provider`, `model`.

    Raises:
        PerceptionError: On an unusable data set, picture or model.
    """
    samples = choose_samples(dataset, split)
    settings = replace(settings or SkinDetectorSettings(), score_threshold=LEAST_SCORE, most_regions=100)
    detector = load(model, settings)
    results, durations = [], []
    for done, sample in enumerate(samples, start=1):
        result, duration = examine(detector, sample)
        results.append(result)
        durations.append(duration)
        if progress is not None:
            progress(done, len(samples))
    if curves is not None:
        draw_curves(results, curves)
    return {
        "map50": _number(mean_average_precision(results, SKIN_CLASSES)),
        "map50_95": _number(mean_average_precision(results, SKIN_CLASSES, THRESHOLDS)),
        "ap50": {name: _number(average_precision(precision_recall(results, name))) for name in SKIN_CLASSES},
        "images": len(results),
        "boxes": {name: precision_recall(results, name).truths for name in SKIN_CLASSES},
        "ms_per_image_p50": round(1e3 * float(np.median(durations)), 2),
        "size_px": detector.size,
        "provider": detector.provider,
        "model": Path(model or settings.model or "skin.onnx").name,
    }


def choose_samples(dataset: Path, split: str) -> list[Sample]:
    """Pictures of a data set by use; never none.

    Raises:
        SettingsError: On an unknown split, or one without pictures.
    """
    if split not in SPLITS:
        raise SettingsError(f"split must be one of {', '.join(SPLITS)}, got {split!r}")
    if split == "all":
        return list_samples(dataset)
    if split == "checked":
        checked = read_checked(dataset)
        samples = [sample for sample in list_samples(dataset) if sample.picture.stem in checked]
    else:
        samples = getattr(split_samples(dataset), split)
    if not samples:
        raise SettingsError(f"{dataset} has no pictures in the split {split!r}; try split 'all'")
    return samples


def examine(detector: Detector, sample: Sample) -> tuple[PictureResult, float]:
    """Truth and detections of one picture, and how long detection took [s]."""
    truths = read_annotation(sample.annotation).regions
    rgb = read_picture(sample.picture).rgb
    begun = time.perf_counter()
    detections = detector.detect(rgb)
    return PictureResult(truths, detections), time.perf_counter() - begun


def draw_curves(results: list[PictureResult], path: Path) -> None:
    """Precision over recall of every class, at an overlap of 0.5."""
    figure = Figure(figsize=(6.0, 5.0), layout="constrained")
    axes = figure.add_subplot(xlabel="recall", ylabel="precision", xlim=(0, 1), ylim=(0, 1.02))
    for name in SKIN_CLASSES:
        curve = precision_recall(results, name)
        if curve.truths:
            axes.plot(curve.recall, curve.precision, label=f"{name} {average_precision(curve):.3f}")
    axes.set_title(f"{len(results)} pictures, mAP50 {mean_average_precision(results, SKIN_CLASSES):.3f}")
    axes.legend(loc="lower left")
    axes.grid(alpha=0.3)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)


def _number(value: float) -> float | None:
    return round(value, 4) if np.isfinite(value) else None
