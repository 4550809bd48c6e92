"""Data sets in memory: read once, drawn with balanced classes."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.errors import AnnotationError
from bathbot_perception.pictures.voc import Sample, check_size, read_annotation, read_checked
from bathbot_perception.regions import Region
from bathbot_perception.training.data.augment_geometry import Example
from bathbot_perception.training.data.corrections import NO_CORRECTIONS, Corrections

UNCHECKED_WEIGHT = 0.6
"""How often a picture with unchecked boxes is drawn, against a checked one."""


def load_example(sample: Sample, long_side: int, corrected: Sequence[Region] | None = None) -> Example:
    """Read a picture and its boxes, difficult ones too, shrunk if its longer side exceeds `long_side` [px].

    Args:
        sample: Picture and boxes.
        long_side: Longer side at most [px].
        corrected: Take these boxes instead, cut at the borders of the picture.

    Raises:
        AnnotationError: If the picture cannot be read or is not of the size its file says.
    """
    annotation = read_annotation(sample.annotation)
    picture = cv2.imread(str(sample.picture), cv2.IMREAD_COLOR)
    if picture is None:
        raise AnnotationError(f"cannot read the picture {sample.picture}; is it a whole JPEG or PNG?")
    height, width = picture.shape[:2]
    check_size(sample, annotation, picture.shape)
    scale = min(long_side / max(height, width), 1.0)
    if scale < 1.0:
        size = (round(width * scale), round(height * scale))
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    regions = (*annotation.regions, *annotation.difficult) if corrected is None else corrected
    boxes = np.array([region.box for region in regions], dtype=np.float64).reshape(-1, 4)
    boxes = np.clip(boxes, 0.0, [width, height, width, height])
    factors = np.array([picture.shape[1] / width, picture.shape[0] / height])
    classes = np.array([SKIN_CLASSES.index(region.name) for region in regions], dtype=np.int64)
    return Example(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), boxes * np.tile(factors, 2), classes)


def class_balance(examples: list[Example]) -> NDArray[np.floating]:
    """How often to draw each example so that rare classes are seen more, shape (n,), mean 1.

    A box weighs the inverse square root of the number of boxes of its class, a picture as much as its boxes
    together; one without boxes half as much as one box of the commonest class.
    """
    counts = np.bincount(np.concatenate([e.classes for e in examples]), minlength=len(SKIN_CLASSES))
    rarity = 1.0 / np.sqrt(np.maximum(counts, 1))
    weights = np.array([rarity[e.classes].sum() if len(e.classes) else 0.5 * rarity.min() for e in examples])
    return weights / weights.mean()


class Source(NamedTuple):
    """Training pictures of one data set, with the chance of each to be drawn."""

    name: str
    examples: list[Example]
    chances: NDArray[np.floating]


def load_source(
    folder: Path, samples: Sequence[Sample], long_side: int, corrections: Corrections = NO_CORRECTIONS
) -> Source:
    """Load training pictures of one folder into memory; corrected boxes count as checked."""
    checked = read_checked(folder)
    used = [sample for sample in samples if corrections.get(sample.picture.name, ()) is not None]
    examples = [load_example(sample, long_side, corrections.get(sample.picture.name)) for sample in used]
    weights = class_balance(examples)
    sure = [s.picture.stem in checked or s.picture.name in corrections for s in used]
    weights *= np.where(sure, 1.0, UNCHECKED_WEIGHT)
    return Source(folder.name, examples, weights / weights.sum())
