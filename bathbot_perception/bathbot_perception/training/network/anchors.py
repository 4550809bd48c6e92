"""Anchor sizes by k-means over the boxes of a data set."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]


def cluster_anchors(sizes: Array, count: int = 9, rounds: int = 60, seed: int = 0) -> Array:
    """Typical box sizes, by k-means over log width and log height.

    Args:
        sizes: Widths and heights of training boxes [px], shape (n, 2), positive.
        count: Number of anchors.
        rounds: Steps of Lloyd's iteration.
        seed: Seed of the first centres.

    Returns:
        Anchors [px] from small to large area, shape (count, 2).
    """
    random = np.random.default_rng(seed)
    points = np.log(sizes)
    centres = points[random.choice(len(points), count, replace=False)]
    for _ in range(rounds):
        nearest = np.square(points[:, None] - centres[None]).sum(axis=-1).argmin(axis=1)
        centres = np.stack(
            [
                points[nearest == index].mean(axis=0)
                if np.any(nearest == index)
                else points[random.integers(len(points))]
                for index in range(count)
            ]
        )
    anchors = np.exp(centres)
    return anchors[np.argsort(anchors.prod(axis=1))]


def best_ratio(sizes: Array, anchors: Array) -> Array:
    """How many times the longer side of a box differs from its best anchor, shape (n,), at least 1."""
    ratio = sizes[:, None] / anchors[None]
    return np.maximum(ratio, 1.0 / ratio).max(axis=-1).min(axis=1)
