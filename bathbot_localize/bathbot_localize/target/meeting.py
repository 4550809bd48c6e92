"""Depth pictures kept for the regions of their time, and the meeting of the two."""

import threading
from collections import deque
from typing import Generic, TypeVar

from bathbot_localize.errors import LocalizeError

Item = TypeVar("Item")
Regions = TypeVar("Regions")


class NoPictureError(LocalizeError):
    """A list of regions whose depth picture never came."""


class StampBuffer(Generic[Item]):
    """Keeps the newest items with their stamps [s]; one thread may write while others read."""

    def __init__(self, size: int) -> None:
        """Keep at most `size` items."""
        self._items: deque[tuple[float, Item]] = deque(maxlen=size)
        self._lock = threading.Lock()

    def add(self, stamp: float, item: Item) -> None:
        """Take in one item; after a jump back in time (a bag played again) the old ones are dropped."""
        with self._lock:
            if self._items and stamp < self._items[-1][0] - 1.0:
                self._items.clear()
            self._items.append((stamp, item))

    @property
    def newest_stamp(self) -> float:
        """Time of the newest item [s]; minus infinity when there is none."""
        with self._lock:
            return self._items[-1][0] if self._items else float("-inf")

    def near(self, stamp: float, tolerance: float) -> list[tuple[float, Item]]:
        """The item nearest to a time, with its stamp; an empty list when none lies within `tolerance` [s]."""
        with self._lock:
            found = min(self._items, key=lambda entry: abs(entry[0] - stamp), default=None)
        return [found] if found is not None and abs(found[0] - stamp) <= tolerance else []


class Meeting(Generic[Regions, Item]):
    """Meets each list of regions with the depth picture of its time, whichever comes first.

    Regions that come while others wait replace them. Only one thread may use it.
    """

    def __init__(self, history: int, tolerance: float) -> None:
        """Keep `history` depth pictures; stamps may differ by `tolerance` [s]."""
        self._depths: StampBuffer[Item] = StampBuffer(history)
        self._tolerance = tolerance
        self._waiting: list[tuple[float, Regions]] = []

    def add_regions(self, stamp: float, regions: Regions) -> None:
        """Let regions of a picture taken at `stamp` [s] wait for their depth picture."""
        self._waiting = [(stamp, regions)]

    def add_depth(self, stamp: float, depth: Item) -> None:
        """Keep a depth picture taken at `stamp` [s]."""
        self._depths.add(stamp, depth)

    def take(self) -> list[tuple[Regions, Item]]:
        """The pair that has met, if there is one; it is given once.

        Raises:
            NoPictureError: The regions that waited are given up: later depth pictures have come already.
        """
        for stamp, regions in self._waiting:
            for _, depth in self._depths.near(stamp, self._tolerance):
                self._waiting = []
                return [(regions, depth)]
            if self._depths.newest_stamp > stamp + self._tolerance:
                self._waiting = []
                raise NoPictureError(
                    f"no depth picture within {self._tolerance} s of the regions' picture; is depth_history "
                    "too short?"
                )
        return []
