"""Skin regions drawn on a picture."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.regions import Region

COLOURS: tuple[tuple[int, int, int], ...] = (
    (230, 159, 0), (86, 180, 233), (0, 158, 115), (240, 228, 66), (213, 94, 0), (204, 121, 167),
)  # fmt: skip
"""RGB of each class, told apart by colour-blind readers too (Okabe and Ito)."""


def draw_regions(rgb: NDArray[np.uint8], regions: Sequence[Region]) -> NDArray[np.uint8]:
    """A copy of the picture, shape (h, w, 3), with boxes, names and scores."""
    canvas = np.ascontiguousarray(rgb).copy()
    unit = max(canvas.shape[:2]) / 640.0
    thickness, size = max(round(2 * unit), 1), 0.45 * max(unit, 0.6)
    for region in sorted(regions, key=lambda region: region.score):
        colour = COLOURS[SKIN_CLASSES.index(region.name)]
        left, top, right, bottom = (round(value) for value in region.box)
        cv2.rectangle(canvas, (left, top), (right, bottom), colour, thickness)
        text = f"{region.name.removesuffix('_skin')} {region.score:.2f}"
        (width, height), below = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, size, 1)
        top = max(top, height + below)
        cv2.rectangle(canvas, (left, top - height - below), (left + width, top), colour, cv2.FILLED)
        cv2.putText(
            canvas, text, (left, top - below // 2), cv2.FONT_HERSHEY_SIMPLEX, size, (0, 0, 0), 1, cv2.LINE_AA
        )
    return canvas
