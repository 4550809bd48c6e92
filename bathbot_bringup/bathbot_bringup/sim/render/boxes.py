"""Boxes of visible skin from part labels, and PASCAL VOC files.

One box per class on the middle of the body, one per left or right limb, hand and foot, round all pieces of a
divided one. A face ends at the chin, the neck is trunk, a bare shoulder is upper limb: the labels say so
already.
"""

from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.pictures.voc import Annotation, write_annotation
from bathbot_perception.regions import Region
from numpy.typing import NDArray

from bathbot_bringup.sim.body import Side

SMALLEST_SIDE = 12  # [px]; smaller boxes are dropped
SMALLEST_PIECE = 12  # [px]; smaller specks of skin do not stretch a box
NARROW = 1 / 32
"""Share of a picture's width below which the shorter side of a box makes it difficult.

At a metre from a D455 this is the width of the brush, 5 cm: what is narrower cannot be washed.
"""


class SkinBox(NamedTuple):
    """A box round visible skin: class 0..5 and inclusive pixel bounds."""

    part: int
    left: int
    top: int
    right: int
    bottom: int


def skin_boxes(parts: NDArray[np.uint8], sides: NDArray[np.uint8]) -> list[SkinBox]:
    """Boxes of the visible skin of one person.

    Args:
        parts: `Part` of each pixel, shape (H, W).
        sides: `Side` of each pixel, shape (H, W).
    """
    boxes = []
    for part in range(len(SKIN_CLASSES)):
        for side in Side:
            mask = ((parts == part) & (sides == side)).astype(np.uint8)
            _, _, pieces, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
            areas = pieces[1:, cv2.CC_STAT_AREA]
            kept = pieces[1:][areas >= max(SMALLEST_PIECE, 0.01 * areas.max(initial=0))]
            if not len(kept):
                continue
            left, top, width, height = kept[:, :4].T
            box = SkinBox(part, left.min(), top.min(), (left + width).max() - 1, (top + height).max() - 1)
            if min(box.right - box.left, box.bottom - box.top) + 1 >= SMALLEST_SIDE:
                boxes.append(SkinBox(*map(int, box)))
    return boxes


def write_voc(path: Path, image_name: str, shape: tuple[int, int], boxes: list[SkinBox]) -> None:
    """Write a PASCAL VOC annotation; its bounds count from 1, boxes that are `NARROW` are marked difficult.

    Args:
        path: The .xml file.
        image_name: Name of the picture.
        shape: Height and width of the picture [px].
        boxes: What is in it.
    """
    height, width = shape
    regions: dict[bool, list[Region]] = {False: [], True: []}
    for box in boxes:
        side = min(box.right - box.left, box.bottom - box.top) + 1
        bounds = tuple(float(value + 1) for value in box[1:])
        regions[side < NARROW * width].append(Region(SKIN_CLASSES[box.part], 1.0, bounds))
    write_annotation(path, Annotation(image_name, width, height, tuple(regions[False]), tuple(regions[True])))
