"""From the model's raw numbers to skin regions in the picture."""

import numpy as np
from numpy.typing import NDArray

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detection.letterbox import Letterbox
from bathbot_perception.detection.nms import suppress
from bathbot_perception.regions import Region

Array = NDArray[np.floating]
MOST_CANDIDATES = 1000
"""Boxes that may enter suppression; the best ones."""


def regions_from_predictions(
    raw: Array,
    fit: Letterbox,
    picture: tuple[int, int],
    score_threshold: float,
    overlap_limit: float,
    most: int,
) -> list[Region]:
    """Regions of one picture, best first.

    Args:
        raw: (centre u, centre v, width, height [px of the input], objectness, class scores), shape (N, 11).
        fit: The letterbox used.
        picture: Height and width of the picture [px]; boxes are cut there.
        score_threshold: Least objectness times class score.
        overlap_limit: Of `suppress`.
        most: Number of regions to return at most.
    """
    raw = raw[np.flatnonzero(raw[:, 4] >= score_threshold)]
    scores = raw[:, 5:] * raw[:, 4:5]
    row, classes = np.nonzero(scores >= score_threshold)
    values = scores[row, classes]
    best = np.argsort(-values, kind="stable")[:MOST_CANDIDATES]
    row, classes, values = row[best], classes[best], values[best]
    middle, half = raw[row, :2], raw[row, 2:4] / 2
    boxes = fit.to_picture(np.concatenate([middle - half, middle + half], axis=1).astype(np.float64))
    height, width = picture
    np.minimum(np.maximum(boxes, 0.0, out=boxes), np.array([width, height, width, height]), out=boxes)
    solid = (boxes[:, 2] > boxes[:, 0]) & (boxes[:, 3] > boxes[:, 1])
    boxes, classes, values = boxes[solid], classes[solid], values[solid]
    kept = suppress(boxes, values, classes, overlap_limit)[:most]
    return [
        Region(SKIN_CLASSES[category], score, tuple(box))
        for category, score, box in zip(
            classes[kept].tolist(), values[kept].tolist(), boxes[kept].tolist(), strict=True
        )
    ]
