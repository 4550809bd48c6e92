"""Precision, recall and average precision of a detector, Eqs. (1)-(2).

A detection is right (TP) if it overlaps a true box of its picture and class by at least the
threshold and no better detection has taken that box; each true box left over is missed (FN).
Average precision is the area under the precision-recall curve at all its points, with
precision made to fall (each point takes the best precision at its recall or above). A detection
of a box marked difficult counts neither way.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_perception.regions import Region, overlap

Array = NDArray[np.floating]
THRESHOLDS: Array = np.linspace(0.5, 0.95, 10)
"""Overlaps of mAP50-95."""


class PrecisionRecall(NamedTuple):
    """The curve of one class; the arrays run by falling score, shape (detections,)."""

    recall: Array
    precision: Array
    scores: Array
    truths: int


class PictureResult(NamedTuple):
    """What is in a picture, what was found in it, and what nobody is blamed for, see `voc.Annotation`."""

    truths: Sequence[Region]
    detections: Sequence[Region]
    difficult: Sequence[Region] = ()


def match_detections(truths: Array, detections: Array, threshold: float) -> NDArray[np.bool_]:
    """Which detections of one picture and class are right.

    Args:
        truths: True boxes [px], shape (n, 4).
        detections: Found boxes [px] by falling score, shape (m, 4).
        threshold: Least overlap.

    Returns:
        Shape (m,).
    """
    right = np.zeros(len(detections), dtype=bool)
    shared = overlap(detections, truths)
    free = np.ones(len(truths), dtype=bool)
    for index in range(len(detections)):
        candidates = np.where(free, shared[index], -1.0)
        if candidates.size and candidates.max() >= threshold:
            free[candidates.argmax()] = False
            right[index] = True
    return right


def precision_recall(results: Sequence[PictureResult], name: str, threshold: float = 0.5) -> PrecisionRecall:
    """Curve of one class over many pictures, Eqs. (1)-(2)."""
    scores, right, truths = [np.zeros(0)], [np.zeros(0, dtype=bool)], 0
    for result in results:
        found = sorted((r for r in result.detections if r.name == name), key=lambda r: -r.score)
        true_boxes, boxes = _boxes(result.truths, name), _boxes(found, name)
        truths += len(true_boxes)
        hits = match_detections(true_boxes, boxes, threshold)
        excused = overlap(boxes, _boxes(result.difficult, name)).max(axis=1, initial=0.0) >= threshold
        counted = hits | ~excused
        scores.append(np.array([r.score for r in found])[counted])
        right.append(hits[counted])
    all_scores, all_right = np.concatenate(scores), np.concatenate(right)
    order = np.argsort(-all_scores, kind="stable")
    hits = np.cumsum(all_right[order])
    tried = np.arange(1, len(order) + 1)
    return PrecisionRecall(hits / max(truths, 1), hits / tried, all_scores[order], truths)


def _boxes(regions: Sequence[Region], name: str) -> Array:
    return np.array([r.box for r in regions if r.name == name], dtype=float).reshape(-1, 4)


def average_precision(curve: PrecisionRecall) -> float:
    """Area under the curve; NaN for a class that occurs nowhere."""
    if curve.truths == 0:
        return float("nan")
    falling = np.maximum.accumulate(curve.precision[::-1])[::-1]
    return float(np.sum(np.diff(curve.recall, prepend=0.0) * falling))


def mean_average_precision(
    results: Sequence[PictureResult], names: Sequence[str], thresholds: Sequence[float] | Array = (0.5,)
) -> float:
    """Mean over classes that occur and over overlap thresholds; NaN if no class occurs."""
    values = np.array(
        [[average_precision(precision_recall(results, n, t)) for n in names] for t in thresholds]
    )
    return float(np.nanmean(values)) if np.isfinite(values).any() else float("nan")
