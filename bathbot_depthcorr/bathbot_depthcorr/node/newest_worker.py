"""A thread that works on the newest items: old frames are dropped, new ones hardly wait."""

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

Item = TypeVar("Item")


class NewestWorker(Generic[Item]):
    """Calls `work` in a thread of its own with the newest items handed over.

    Errors that `work` raises are given to `fail`; the thread goes on with the next item.
    """

    def __init__(
        self,
        work: Callable[[Item], None],
        fail: Callable[[Exception], None],
        waiting: int = 1,
        patience: float = math.inf,
    ) -> None:
        """Start the thread.

        Args:
            work: Called with one item at a time.
            fail: Called with an exception that `work` raised.
            waiting: How many items may wait before the oldest is dropped; more than one bridges a pause of
                the machine.
            patience: How long an item may wait while a newer one waits too [s]; bounds how late a thread
                that is always too slow can be.
        """
        self._work, self._fail = work, fail
        self._condition = threading.Condition()
        self._waiting: deque[tuple[float, Item]] = deque(maxlen=waiting)
        self._patience = patience
        self._open = True
        self.done = 0
        self.dropped = 0
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def put(self, item: Item) -> None:
        """Hand over an item; if too many wait, the oldest is dropped and counted."""
        with self._condition:
            self.dropped += len(self._waiting) == self._waiting.maxlen
            self._waiting.append((time.monotonic(), item))
            self._condition.notify_all()

    def settle(self, timeout: float) -> None:
        """Wait until no item waits any more, at most `timeout` [s]."""
        with self._condition:
            self._condition.wait_for(lambda: not self._waiting, timeout)

    def close(self, timeout: float = 2.0) -> None:
        """Stop after the item in work, waiting at most `timeout` [s]."""
        with self._condition:
            self._open = False
            self._condition.notify()
        if self._thread is not threading.current_thread():
            self._thread.join(timeout)

    def _run(self) -> None:
        while True:
            with self._condition:
                self._condition.wait_for(lambda: self._waiting or not self._open)
                if not self._open:
                    return
                item = self._next()
                self._condition.notify_all()
            try:
                self._work(item)
            except Exception as error:  # the owner decides; this thread must live on
                self._fail(error)
            self.done += 1

    def _next(self) -> Item:
        """Take the oldest item that did not wait too long, or the newest."""
        arrived, item = self._waiting.popleft()
        while self._waiting and time.monotonic() - arrived > self._patience:
            self.dropped += 1
            arrived, item = self._waiting.popleft()
        return item
