"""Remember where the chosen region was seen before the arm came.

While the arm works on a region it hides it, and the detector loses it or finds only a part. The
box in which the region was last seen free of the arm then goes on to count, so that the surface is
still measured where the arm leaves it open. Without the arm in the way a lost region is forgotten
after a short time.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bathbot_localize.regions import SkinRegion
from bathbot_localize.surface.registration import OutsideImageError, clip_box

_HIDDEN = 0.04  # share of a box from which the arm is in the way
_SAME = 0.3  # overlap from which two boxes show one region


def hidden_share(box: Sequence[float], silhouette: NDArray[np.bool_]) -> float:
    """Share of a box that the arm covers; 0 for a box outside the picture."""
    try:
        left, top, right, bottom = clip_box(box, silhouette.shape[1], silhouette.shape[0])
    except OutsideImageError:
        return 0.0
    return float(silhouette[top:bottom, left:right].mean())


def box_overlap(first: Sequence[float], second: Sequence[float]) -> float:
    """Shared area of two boxes over the area of the smaller one, 0..1."""
    width = min(first[2], second[2]) - max(first[0], second[0])
    height = min(first[3], second[3]) - max(first[1], second[1])
    smaller = min((box[2] - box[0]) * (box[3] - box[1]) for box in (first, second))
    return max(width, 0.0) * max(height, 0.0) / smaller if smaller > 0.0 else 0.0


class RoiMemory:
    """The region of interest of one named region over time."""

    def __init__(self, name: str, patience: float) -> None:
        """Follow the region `name`; forget it `patience` [s] after it was lost without the arm in the way."""
        self.name, self._patience = name, patience
        self._free: SkinRegion | None = None
        self._seen = -np.inf

    def update(
        self, region: SkinRegion | None, silhouette: NDArray[np.bool_], stamp: float
    ) -> SkinRegion | None:
        """Take in what the detector says and return the region to measure, or None.

        Args:
            region: Detected region of this name, or None when it was not found.
            silhouette: Pixels the arm covers, shape (H, W).
            stamp: Time of the picture [s].
        """
        if region is not None and hidden_share(region.box, silhouette) < _HIDDEN:
            part_of_hidden = (
                self._free is not None
                and hidden_share(self._free.box, silhouette) >= _HIDDEN
                and box_overlap(region.box, self._free.box) >= _SAME
            )
            self._seen = stamp
            if not part_of_hidden:
                self._free = region
            return self._free
        if self._free is not None and hidden_share(self._free.box, silhouette) >= _HIDDEN:
            self._seen = stamp
            return self._free
        if region is not None:
            self._seen = stamp
            return region  # never seen free: better a part than nothing
        if stamp - self._seen > self._patience:
            self._free = None
        return self._free
