"""How well a model finds the boxes of a data set: numbers for a report and curves for a picture."""

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detection.detector import Detector, load
from bathbot_perception.detection.settings import SkinDetectorSettings
from bathbot_perception.errors import AnnotationError, SettingsError
from bathbot_perception.evaluation.average_precision import (
    THRESHOLDS,
    PictureResult,
    average_precision,
    mean_average_precision,
    precision_recall,
)
from bathbot_perception.evaluation.conditions import CONDITIONS, STRENGTHS, disturbed
from bathbot_perception.evaluation.confusion import confusion
from bathbot_perception.evaluation.skin_tone import THIRDS, thirds, typology_angle
from bathbot_perception.pictures.pictures import read_picture
from bathbot_perception.pictures.splits import split_samples
from bathbot_perception.pictures.voc import (
    Annotation,
    Sample,
    check_size,
    list_samples,
    read_annotation,
    read_checked,
)

LEAST_SCORE = 0.01
"""Detections down to this score enter the curves."""
SPLITS = ("all", "checked", "train", "val", "test")


class Examined(NamedTuple):
    """What a model made of a data set."""

    results: list[PictureResult]
    durations: list[float]  # [s] of each picture
    angles: list[float]  # [deg] ITA of each, see `skin_tone`


def evaluate(
    dataset: Path,
    model: Path | str | None = None,
    settings: SkinDetectorSettings | None = None,
    split: str = "all",
    curves: Path | None = None,
    conditions: Sequence[str] = tuple(CONDITIONS),
    progress: Callable[[int, int], None] = lambda done, count: None,
) -> dict[str, object]:
    """Run a model over a PASCAL VOC data set, as it is and disturbed.

    Args:
        dataset: Folder with `images/` and `annotations/`.
        model: ONNX file; without it the one of the settings or of the package.
        settings: Provider, threads, size and overlap limit; the score limit applies to the confusion only.
        split: Which pictures: one of `SPLITS`; see `splits.split_samples`.
        curves: PNG file to draw the precision-recall curves to.
        conditions: Keys of `conditions.CONDITIONS` to try; none to leave them out.
        progress: Called with (pictures looked at, in all).

    Returns:
        `map50`, `map50_95`, `ap50` per class (None where a class does not occur), `images`, `boxes` per
        class, `confusion` (rows true, columns found, background last), `conditions` {name: {strength:
        mAP50}}, with the thirds of `skin_tone` among them, `ita_deg` between these thirds, `difficult`
        (number of boxes marked so, which count neither way), `map50_with_difficult` (as if they were like
        all others), `ms_per_image_p50`, `size_px`, `provider`, `model`.

    Raises:
        PerceptionError: On an unusable data set, picture or model, or an unknown condition.
    """
    if unknown := [name for name in conditions if name not in CONDITIONS]:
        raise SettingsError(f"unknown condition {unknown[0]!r}; known are {', '.join(CONDITIONS)}")
    samples, settings = choose_samples(dataset, split), settings or SkinDetectorSettings()
    detector = load(model, replace(settings, score_threshold=LEAST_SCORE, most_regions=100))
    count = len(samples) * (1 + len(conditions) * len(STRENGTHS))
    done = itertools.count(1)

    def tell() -> None:
        progress(next(done), count)

    clean = examine(detector, samples, tell)
    if not any(result.truths for result in clean.results):
        raise AnnotationError(
            f"no picture of {dataset} has a box of a skin class that is not difficult; nothing to compare"
        )
    if curves is not None:
        draw_curves(clean.results, curves)
    tables = {
        name: {
            strength: _map50(examine_under(detector, samples, name, strength, tell)) for strength in STRENGTHS
        }
        for name in conditions
    }
    groups = thirds(clean.angles)
    if conditions:
        tables["skin_tone"] = {
            third: _map50([r for r, mine in zip(clean.results, groups, strict=True) if mine == third])
            for third in THIRDS
        }
    known = [angle for angle in clean.angles if np.isfinite(angle)]
    return {
        "map50": _map50(clean.results),
        "map50_95": _number(mean_average_precision(clean.results, SKIN_CLASSES, THRESHOLDS)),
        "ap50": {
            name: _number(average_precision(precision_recall(clean.results, name))) for name in SKIN_CLASSES
        },
        "images": len(clean.results),
        "boxes": {name: precision_recall(clean.results, name).truths for name in SKIN_CLASSES},
        "confusion": confusion(clean.results, settings.score_threshold).tolist(),
        "conditions": tables,
        "difficult": sum(len(result.difficult) for result in clean.results),
        "map50_with_difficult": _map50(
            [PictureResult((*r.truths, *r.difficult), r.detections) for r in clean.results]
        ),
        "ita_deg": [round(float(v), 1) for v in np.quantile(known, [1 / 3, 2 / 3])] if known else [],
        "ms_per_image_p50": round(1e3 * float(np.median(clean.durations)), 2),
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


def labelled_picture(sample: Sample) -> tuple[Annotation, NDArray[np.uint8]]:
    """Annotation and RGB of a sample.

    Raises:
        PerceptionError: If one of the files cannot be read or they are of different sizes.
    """
    annotation, rgb = read_annotation(sample.annotation), read_picture(sample.picture).rgb
    check_size(sample, annotation, rgb.shape)
    return annotation, rgb


def examine(detector: Detector, samples: Sequence[Sample], tell: Callable[[], None]) -> Examined:
    """Truth, detections, time and skin tone of every picture; `tell` is called after each."""
    examined = Examined([], [], [])
    for sample in samples:
        annotation, rgb = labelled_picture(sample)
        begun = time.perf_counter()
        detections = detector.detect(rgb)
        examined.durations.append(time.perf_counter() - begun)
        examined.results.append(PictureResult(annotation.regions, detections, annotation.difficult))
        examined.angles.append(typology_angle(rgb, annotation.regions))
        tell()
    return examined


def examine_under(
    detector: Detector, samples: Sequence[Sample], condition: str, strength: str, tell: Callable[[], None]
) -> list[PictureResult]:
    """Truth and detections of every picture under a condition of `conditions.CONDITIONS`."""
    results = []
    for sample in samples:
        annotation, rgb = labelled_picture(sample)
        boxes = np.array([region.box for region in annotation.regions]).reshape(-1, 4)
        picture = disturbed(rgb, boxes, condition, strength, sample.picture.stem)
        results.append(PictureResult(annotation.regions, detector.detect(picture), annotation.difficult))
        tell()
    return results


def draw_curves(results: Sequence[PictureResult], path: Path) -> None:
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


def _map50(results: Sequence[PictureResult]) -> float | None:
    return _number(mean_average_precision(results, SKIN_CLASSES))


def _number(value: float) -> float | None:
    return round(value, 4) if np.isfinite(value) else None
