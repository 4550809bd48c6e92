"""Steadier boxes over time. A box that was not found in this picture is never shown."""

from collections.abc import Sequence

import numpy as np

from bathbot_perception.regions import Region, overlap

_SAME = 0.3  # least overlap of one region in two pictures


class Smoothing:
    """Moves every box a share of the way from where it was in the picture before."""

    def __init__(self, share: float) -> None:
        """Begin without a picture; `share` of the old box that stays, 0..1: 0 changes nothing."""
        self._share = share
        self._before: list[Region] = []

    def update(self, regions: Sequence[Region]) -> list[Region]:
        """The regions of the newest picture, in their order, scores and classes untouched."""
        if not self._share:
            return list(regions)
        free, smooth = list(self._before), []
        for region in regions:
            mine = [index for index, old in enumerate(free) if old.name == region.name]
            if mine:
                shared = overlap(np.array(region.box), np.array([free[index].box for index in mine]))[0]
                best = int(np.argmax(shared))
                if shared[best] >= _SAME:
                    old = free.pop(mine[best])
                    box = (1.0 - self._share) * np.array(region.box) + self._share * np.array(old.box)
                    region = region._replace(box=tuple(map(float, box)))
            smooth.append(region)
        self._before = smooth
        return smooth
