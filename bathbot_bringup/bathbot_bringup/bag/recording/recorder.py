"""Recording without waiting: callers put messages into a queue, one thread writes them into a bag.

A disk that is full, or has gone, stops nobody: what comes meanwhile is missing, which is counted and said,
and every few seconds it is tried again.
"""

import queue
import struct
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from bathbot_depthcorr.ros.verdict import Level, Verdict
from rosbags.serde import SerdeError

from bathbot_bringup.bag.message_types import installed_types
from bathbot_bringup.bag.recording.mcap_bag import McapBag, Source, Stored, Topic
from bathbot_bringup.bag.recording.privacy import PrivacyProfile
from bathbot_bringup.errors import BagError

LOST, REFUSED = "lost", "refused"
"""Names in a bag's notes: messages lost on the way, and not let through."""
_SYNC = 0.5  # [s] between two moments at which all is on the disk
_AGAIN = 2.0  # [s] between attempts to go on after a failure


class BagSummary(NamedTuple):
    """What a closed bag holds, and what it lacks."""

    path: Path
    messages: int
    lost: int  # on their way here, or since
    refused: int


class Recorder:
    """Writes a bag at `target`, as `McapBag` does, in a thread of its own.

    Attributes:
        messages: How many were written.
        dropped: How many were lost since they came here.
        missed: How many were lost on their way here.
        refused: How many the privacy profile did not let through.
        failure: Why nothing is written at this moment; empty while all is well.
    """

    def __init__(
        self,
        target: Path,
        profile: PrivacyProfile,
        notes: dict[str, str] | None = None,
        queue_bytes: int = 256 << 20,
    ) -> None:
        """Open the bag and start the writing thread.

        Args:
            target: Where the bag shall lie.
            profile: Says what each message must keep to.
            notes: Custom data for the metadata, such as the privacy profile.
            queue_bytes: What may wait unwritten; what exceeds it is dropped and counted.

        Raises:
            BagError: When the target exists or its folder cannot be written.
        """
        self._target = target.absolute()
        self._bag, self._profile = McapBag(self._target, notes or {}), profile
        self._queue: queue.SimpleQueue[Stored | Topic | None] = queue.SimpleQueue()
        self._limit, self._waiting = queue_bytes, 0
        self._lock = threading.Lock()
        self.messages = self.dropped = self.missed = self.refused = 0
        self._refusal = ""  # the last one
        self.failure, self._failed = "", 0.0
        self._thread = threading.Thread(target=self._work, name="bag writer")
        self._thread.start()

    @staticmethod
    def knows(message_type: str) -> bool:
        """Tell whether the definition of a type is installed; others cannot be recorded."""
        return message_type in installed_types().fielddefs

    def add(self, topic: Topic) -> None:
        """Announce a topic before its first message."""
        self._queue.put(topic)

    def put(self, message: Stored) -> None:
        """Hand over a message of a topic that was announced; never waits."""
        with self._lock:
            if self._waiting + len(message.data) > self._limit:
                self.dropped += 1
                return
            self._waiting += len(message.data)
        self._queue.put(message)

    def refuse(self, source: Source, size: int) -> None:
        """Take note of a message that was refused unread, for its size [bytes]."""
        with self._lock:
            self.refused += 1
            self._refusal = f"{source.topic}: {size} bytes"

    def miss(self, count: int) -> None:
        """Take note of messages that never came here."""
        self.missed += count

    @property
    def lost(self) -> int:
        """Messages that the bag lacks, wherever they were lost."""
        return self.missed + self.dropped

    def verdict(self) -> Verdict:
        """How it goes."""
        if self.failure:
            return Verdict(Level.ERROR, f"the bag lacks {self.lost} messages so far: {self.failure}")
        if self.lost:
            return Verdict(Level.WARN, f"the bag lacks {self.lost} messages: disk or machine are too slow")
        if self.refused:
            what = f"{self.refused} messages that profile {self._profile.name} does not let through"
            return Verdict(Level.WARN, f"{what}: {self._refusal}")
        return Verdict(Level.OK, f"recording profile {self._profile.name}")

    def close(self) -> BagSummary:
        """Write what still waits and end the bag.

        Raises:
            BagError: When it could not be written to the end; what was written can be read.
        """
        self._queue.put(None)
        self._thread.join()
        if self.failure:
            self._bag.abandon()
            raise BagError(
                f"bag {self._target} lacks {self.lost} messages and its index: {self.failure}; what was "
                "written can be read, `bathbot repair` gives it an index"
            )
        return BagSummary(self._target, self.messages, self.lost, self.refused)

    def _work(self) -> None:
        due, going = time.monotonic() + _SYNC, True
        while going:
            with suppress(queue.Empty):
                item = self._queue.get(timeout=max(due - time.monotonic(), 0.0))
                going = item is not None
                self._take(item)
            if time.monotonic() >= due:
                due = time.monotonic() + _SYNC
                self._attempt(self._bag.sync)
        self._failed = 0.0  # the end is no time to wait
        self._bag.note({LOST: str(self.lost), REFUSED: str(self.refused)})
        self._attempt(self._bag.close)

    def _take(self, item: Stored | Topic | None) -> None:
        if isinstance(item, Topic):
            self._bag.add(item)
        elif item is not None:
            with self._lock:
                self._waiting -= len(item.data)
            if refusal := self._look_into(item):
                with self._lock:
                    self.refused += 1
                    self._refusal = f"{item.source.topic}: {refusal}"
            elif self.failure:
                with self._lock:
                    self.dropped += 1
            else:
                self.messages += 1
                self._attempt(lambda: self._bag.write(item))

    def _look_into(self, message: Stored) -> str:
        """Why a message may not be recorded; empty when it may."""
        topic, kind = message.source
        bounds = self._profile.bounds(topic, kind)
        if bounds is None:
            return f"type {kind}"
        try:
            return self._profile.refusal(
                bounds, len(message.data), lambda: installed_types().deserialize_cdr(message.data, kind)
            )
        except (SerdeError, ValueError, IndexError, AssertionError, struct.error) as error:
            return f"it cannot be decoded: {error}"

    def _attempt(self, action: Callable[[], None]) -> None:
        """Do something to the bag, but not soon after it has failed."""
        if self.failure and time.monotonic() - self._failed < _AGAIN:
            return
        try:
            action()
            self.failure = ""
        except OSError as error:
            self.failure, self._failed = error.strerror or str(error), time.monotonic()
