"""Pictures of the model card: what conditions look like, and where the detector fails."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detection.detector import Detector
from bathbot_perception.evaluation.average_precision import PictureResult, precision_recall
from bathbot_perception.evaluation.conditions import CONDITIONS, STRENGTHS, disturbed
from bathbot_perception.evaluation.evaluate import labelled_picture
from bathbot_perception.pictures.draw import draw_regions
from bathbot_perception.pictures.voc import Sample

Picture = NDArray[np.uint8]
_TILE = (320, 240)  # width and height [px]


def condition_sheet(detector: Detector, sample: Sample, out: Path) -> None:
    """One picture under every condition (down) at every strength (across), with what is found then."""
    annotation, rgb = labelled_picture(sample)
    boxes = np.array([region.box for region in annotation.regions]).reshape(-1, 4)
    rows = []
    for name in CONDITIONS:
        tiles = []
        for strength in STRENGTHS:
            picture = disturbed(rgb, boxes, name, strength, sample.picture.stem)
            tiles.append(_tile(draw_regions(picture, detector.detect(picture)), f"{name}, {strength}"))
        rows.append(np.hstack(tiles))
    _write(out, np.vstack(rows))


def failure_sheet(detector: Detector, samples: Sequence[Sample], out: Path, count: int = 6) -> None:
    """The pictures with the most missed and wrong boxes: truth at the left, found at the right."""
    looks = []
    for sample in samples:
        annotation, rgb = labelled_picture(sample)
        result = PictureResult(annotation.regions, detector.detect(rgb), annotation.difficult)
        looks.append((mistakes(result), rgb, result))
    looks.sort(key=lambda look: -look[0])
    rows = [
        np.hstack(
            [
                _tile(draw_regions(rgb, result.truths), "true"),
                _tile(draw_regions(rgb, result.detections), f"found, {wrong} mistakes"),
            ]
        )
        for wrong, rgb, result in looks[:count]
    ]
    columns = [np.vstack(rows[side::2]) for side in range(2)] if len(rows) % 2 == 0 else [np.vstack(rows)]
    _write(out, np.hstack(columns))


def mistakes(result: PictureResult) -> int:
    """Missed and wrong boxes at an overlap of 0.5."""
    count = 0
    for name in SKIN_CLASSES:
        curve = precision_recall([result], name)
        found = len(curve.scores)
        right = round(float(curve.precision[-1]) * found) if found else 0
        count += curve.truths + found - 2 * right
    return count


def _tile(rgb: Picture, title: str) -> Picture:
    """A picture on a tile, its title in a strip above it."""
    width, height = _TILE
    scale = min(width / rgb.shape[1], height / rgb.shape[0])
    small = cv2.resize(rgb, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    tile = np.full((height + 18, width, 3), 255, np.uint8)
    tile[18 : 18 + small.shape[0], : small.shape[1]] = small[:height, :width]
    cv2.putText(tile, title, (4, 13), cv2.FONT_HERSHEY_SIMPLEX, 0.42, (0, 0, 0), 1, cv2.LINE_AA)
    return tile


def _write(out: Path, rgb: Picture) -> None:
    out.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(out), cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, 85])
