"""What is taken for what: the confusion matrix of a detector, the paper's background as the seventh class."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.evaluation.average_precision import PictureResult
from bathbot_perception.regions import overlap

BACKGROUND = len(SKIN_CLASSES)


def confusion(
    results: Sequence[PictureResult], score: float, overlap_limit: float = 0.5
) -> NDArray[np.int64]:
    """Count regions by true class (row) and found class (column), shape (7, 7); the last is background.

    Pairs are made by falling overlap, whatever their classes. A true region without a pair was taken for
    background, a found one without a pair was background, unless a difficult region lies there.

    Args:
        results: Truth and detections of every picture.
        score: Detections below are left out.
        overlap_limit: Least overlap of a pair.
    """
    counts = np.zeros((BACKGROUND + 1, BACKGROUND + 1), np.int64)
    for result in results:
        found = [region for region in result.detections if region.score >= score]
        true_ids = [SKIN_CLASSES.index(region.name) for region in result.truths]
        found_ids = [SKIN_CLASSES.index(region.name) for region in found]
        shared = overlap(
            np.array([region.box for region in result.truths]), np.array([region.box for region in found])
        )
        hard = overlap(
            np.array([region.box for region in found]), np.array([region.box for region in result.difficult])
        ).max(axis=1, initial=0.0)
        free_true, free_found = set(range(len(true_ids))), set(range(len(found_ids)))
        for flat in np.argsort(-shared, axis=None, kind="stable"):
            row, column = np.unravel_index(flat, shared.shape)
            if shared[row, column] < overlap_limit:
                break
            if row in free_true and column in free_found:
                free_true.remove(row)
                free_found.remove(column)
                counts[true_ids[row], found_ids[column]] += 1
        for row in free_true:
            counts[true_ids[row], BACKGROUND] += 1
        for column in (column for column in free_found if hard[column] < overlap_limit):
            counts[BACKGROUND, found_ids[column]] += 1
    return counts
