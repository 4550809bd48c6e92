"""The last few items of a stream, to be found again by their time."""

import threading
from collections import deque
from typing import Generic, TypeVar

Item = TypeVar("Item")


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
