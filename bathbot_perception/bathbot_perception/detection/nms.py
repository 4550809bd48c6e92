"""Non-maximum suppression, class by class: of boxes that overlap much, keep the best."""

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


def suppress(
    boxes: Array, scores: Array, classes: NDArray[np.integer], overlap_limit: float
) -> NDArray[np.intp]:
    """Indices of the boxes to keep, best first.

    A box goes if a kept box of its class with a higher score overlaps it by more than
    `overlap_limit`. Equal scores keep their order.

    Args:
        boxes: (left, top, right, bottom) [px], shape (n, 4).
        scores: Shape (n,), not negative.
        classes: Class ids, shape (n,).
        overlap_limit: Intersection over union in [0, 1].

    Returns:
        Indices into `boxes`, by falling score.
    """
    corner_and_size = np.concatenate([boxes[:, :2], boxes[:, 2:] - boxes[:, :2]], axis=1).astype(np.float64)
    kept = cv2.dnn.NMSBoxesBatched(
        corner_and_size, scores.astype(np.float32), classes.astype(np.int32), -1.0, overlap_limit
    )
    return np.asarray(kept, dtype=np.intp)
