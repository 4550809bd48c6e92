"""Non-maximum suppression, class by class: of boxes that overlap much, keep the best."""

import numpy as np
from numpy.typing import NDArray

from bathbot_perception.regions import overlap

Array = NDArray[np.floating]


def suppress(
    boxes: Array, scores: Array, classes: NDArray[np.integer], overlap_limit: float
) -> NDArray[np.intp]:
    """Indices of the boxes to keep, best first.

    A box goes if a kept box of its class with a higher score overlaps it by more than
    `overlap_limit`. Equal scores keep their order.

    Args:
        boxes: (left, top, right, bottom) [px], shape (n, 4).
        scores: Shape (n,).
        classes: Class ids, shape (n,).
        overlap_limit: Intersection over union in [0, 1].

    Returns:
        Indices into `boxes`, by falling score.
    """
    kept: list[int] = []
    for name in np.unique(classes):
        rest = np.flatnonzero(classes == name)
        rest = rest[np.argsort(-scores[rest], kind="stable")]
        while rest.size:
            best, rest = rest[0], rest[1:]
            kept.append(int(best))
            rest = rest[overlap(boxes[best], boxes[rest])[0] <= overlap_limit]
    order = np.array(kept, dtype=np.intp)
    return order[np.argsort(-scores[order], kind="stable")]
