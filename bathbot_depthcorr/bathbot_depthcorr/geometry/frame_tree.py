"""Transforms between named frames, with a short memory of those that move."""

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.errors import DepthcorrError
from bathbot_depthcorr.geometry.rigid import inverse, transform_from

Array = NDArray[np.float64]


class UnknownFrameError(DepthcorrError):
    """Two frames that no chain of transforms joins, at least not at that time."""


class Edge(NamedTuple):
    """The transform of a child frame to its parent, valid at one time."""

    stamp: float
    transform: Array


class FrameTree:
    """What /tf and /tf_static tell, for look-ups at the time of a picture."""

    def __init__(self, memory: int = 200) -> None:
        """Keep the last `memory` transforms of each moving frame."""
        self._memory = memory
        self._parent: dict[str, str] = {}
        self._edges: dict[str, deque[Edge]] = {}

    def add(self, parent: str, child: str, transform: Array, stamp: float | None = None) -> None:
        """Take in T_parent_child, shape (4, 4), of time `stamp` [s]; without a stamp it holds for ever."""
        if stamp is None or self._parent.get(child) != parent or child not in self._edges:
            self._edges[child] = deque(maxlen=1 if stamp is None else self._memory)
        self._parent[child] = parent
        self._edges[child].append(
            Edge(np.nan if stamp is None else stamp, np.asarray(transform, dtype=float))
        )

    def lookup(self, target: str, source: str, stamp: float | None = None, tolerance: float = 0.1) -> Array:
        """T_target_source, shape (4, 4), at a time [s], or the newest.

        A moving frame is taken to move evenly from one transform told to the next; before the first and
        after the last it is where that says.

        Raises:
            UnknownFrameError: When no chain joins the frames, or one on the way has no transform
                within `tolerance` [s] of the time.
        """
        to_target, to_source = self._chain(target), self._chain(source)
        shared = next((frame for frame in to_source if frame in to_target), None)
        if shared is None:
            raise UnknownFrameError(
                f"no transform from {source} to {target}; known frames are "
                f"{', '.join(sorted({*self._parent, *self._parent.values()})) or 'none'}"
            )
        up = self._climb(to_source, shared, stamp, tolerance)
        return inverse(self._climb(to_target, shared, stamp, tolerance)) @ up

    def _chain(self, frame: str) -> list[str]:
        chain = [frame]
        while chain[-1] in self._parent and len(chain) <= len(self._parent):
            chain.append(self._parent[chain[-1]])
        return chain

    def _climb(self, chain: list[str], top: str, stamp: float | None, tolerance: float) -> Array:
        """Transform of the first frame of `chain` to its ancestor `top`."""
        transform = np.eye(4)
        for frame in chain[: chain.index(top)]:
            transform = self._at(frame, stamp, tolerance) @ transform
        return transform

    def _at(self, child: str, stamp: float | None, tolerance: float) -> Array:
        edges = self._edges[child]
        if stamp is None or np.isnan(edges[-1].stamp):
            return edges[-1].transform
        before, after = _around(edges, stamp)
        away = min(abs(before.stamp - stamp), abs(after.stamp - stamp))
        if away > tolerance:
            raise UnknownFrameError(
                f"the transform of {child} nearest to the picture is {away:.2f} s "
                f"away, allowed is {tolerance} s; does its publisher run, and on the same clock?"
            )
        return _between(before, after, stamp)


def _around(edges: Iterable[Edge], stamp: float) -> tuple[Edge, Edge]:
    """The last edge before and the first after a time [s]; one that is missing is as the other."""
    before = after = None
    for edge in edges:
        if edge.stamp <= stamp and (before is None or edge.stamp > before.stamp):
            before = edge
        if edge.stamp >= stamp and (after is None or edge.stamp < after.stamp):
            after = edge
    return before or after, after or before


def _between(before: Edge, after: Edge, stamp: float) -> Array:
    """The transform at a time [s] between two edges, shape (4, 4)."""
    if after.stamp <= before.stamp:
        return after.transform
    share = (stamp - before.stamp) / (after.stamp - before.stamp)
    start, end = before.transform, after.transform
    turn, _ = cv2.Rodrigues(end[:3, :3] @ start[:3, :3].T)  # ten times as fast as scipy's Rotation
    turned = cv2.Rodrigues(share * turn)[0] @ start[:3, :3]
    return transform_from(turned, start[:3, 3] + share * (end[:3, 3] - start[:3, 3]))
