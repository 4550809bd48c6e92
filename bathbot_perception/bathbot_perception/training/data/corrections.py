"""Better boxes for pictures of a data set, in one JSON file apart from the pictures.

The file holds {picture file: [[class, left, top, right, bottom], ...]} with boxes in pixels, or null for a
picture that is to be left out.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import AnnotationError
from bathbot_perception.regions import Region

Corrections = Mapping[str, tuple[Region, ...] | None]
NO_CORRECTIONS: Corrections = MappingProxyType({})


def read_corrections(path: Path) -> Corrections:
    """Read a file of corrections.

    Raises:
        AnnotationError: On a file that cannot be read, another form, an unknown class or an empty box.
    """
    try:
        listed = json.loads(path.read_text(encoding="utf-8"))
        return {
            name: None if boxes is None else tuple(_region(*box) for box in boxes)
            for name, boxes in listed.items()
        }
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise AnnotationError(
            f"cannot use {path} as corrections: {error}; "
            'want {"picture.jpg": [["Face_skin", left, top, right, bottom], ...] or null}'
        ) from error


def _region(name: str, left: float, top: float, right: float, bottom: float) -> Region:
    if name not in SKIN_CLASSES:
        raise ValueError(f"unknown class {name!r}, expected one of {', '.join(SKIN_CLASSES)}")
    box = tuple(float(value) for value in (left, top, right, bottom))
    if not (box[2] > box[0] and box[3] > box[1]):
        raise ValueError(f"the box {box} of {name} is empty")
    return Region(name, 1.0, box)
