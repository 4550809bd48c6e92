"""Writing a rosbag2 bag: callers put messages into a queue, one thread writes them.

The bag is built in a hidden folder beside its target and moved when it is whole, so a
half-written bag never carries the name a user asked for.
"""

import os
import queue
import shutil
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from bathbot_depthcorr.ros.verdict import Level, Verdict
from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import StoragePlugin, Writer

from bathbot_bringup.errors import BagError
from bathbot_bringup.graph.message_types import installed_types


class Topic(NamedTuple):
    """A topic to record: resolved name, type such as `std_msgs/msg/Header`, offered quality of service."""

    name: str
    message_type: str
    qos: Sequence[Qos]


class BagSummary(NamedTuple):
    """What a closed bag holds."""

    path: Path
    messages: int
    dropped: int


def refuse_existing(target: Path) -> None:
    """Make sure that nothing is overwritten.

    Raises:
        BagError: When the target exists.
    """
    if target.exists():
        raise BagError(f"{target} exists already and is not overwritten; choose another name or remove it")


class Recorder:
    """Writes a bag at `target`: a folder, or a single file when the name ends in `.mcap`."""

    def __init__(
        self, target: Path, notes: dict[str, str] | None = None, queue_bytes: int = 256 << 20
    ) -> None:
        """Open the bag and start the writing thread.

        Args:
            target: Where the bag shall lie when it is whole.
            notes: Custom data for the metadata, such as the privacy profile.
            queue_bytes: What may wait unwritten; what exceeds it is dropped and counted.

        Raises:
            BagError: When the target exists or its folder cannot be written.
        """
        target = target.absolute()
        refuse_existing(target)
        self._target, self._single = target, target.suffix == ".mcap"
        self._building = target.parent / f".{target.name}.{os.getpid()}.part"
        self._built = self._building / (target.stem if self._single else target.name)
        self._writer = Writer(self._built, version=9, storage_plugin=StoragePlugin.MCAP)
        for key, value in (notes or {}).items():
            self._writer.set_custom_data(key, value)
        try:
            self._writer.open()
        except OSError as error:
            raise BagError(
                f"cannot write a bag at {target}: {error.strerror}; choose another place"
            ) from error
        self._connections: dict[str, Connection] = {}
        self._queue: queue.SimpleQueue[tuple[str, int, bytes] | Topic | None] = queue.SimpleQueue()
        self._limit, self._waiting = queue_bytes, 0
        self._lock = threading.Lock()
        self.messages = self.dropped = 0
        self.failure = ""
        self._thread = threading.Thread(target=self._write, name="bag writer")
        self._thread.start()

    @staticmethod
    def knows(message_type: str) -> bool:
        """Tell whether the definition of a type is installed; others cannot be recorded."""
        return message_type in installed_types().fielddefs

    def add(self, topic: Topic) -> None:
        """Announce a topic before its first message."""
        self._queue.put(topic)

    def put(self, topic: str, time: int, data: bytes) -> None:
        """Hand over a serialised message; never waits.

        Args:
            topic: Resolved name, announced by `add`.
            time: When it was received [ns].
            data: The CDR bytes.
        """
        with self._lock:
            if self.failure or self._waiting + len(data) > self._limit:
                self.dropped += 1
                return
            self._waiting += len(data)
        self._queue.put((topic, time, data))

    def verdict(self, profile: str) -> Verdict:
        """How it goes with recording what a privacy profile of this name allows."""
        if self.failure:
            return Verdict(Level.ERROR, f"cannot write the bag: {self.failure}")
        if self.dropped:
            return Verdict(Level.WARN, "the disk is too slow, messages were dropped")
        return Verdict(Level.OK, f"recording profile {profile}")

    def close(self) -> BagSummary:
        """Write what still waits, close the bag and give it its name.

        Raises:
            BagError: When writing failed on the way; what was written is kept and named in the message.
        """
        self._queue.put(None)
        self._thread.join()
        try:
            if self.failure:
                raise OSError(self.failure)
            self._writer.close()
            self._publish()
        except OSError as error:
            raise BagError(
                f"bag {self._target} is not whole: {error}; what was written is in {self._building}"
            ) from error
        return BagSummary(self._target, self.messages, self.dropped)

    def _publish(self) -> None:
        if self._single:
            os.replace(self._built / self._target.name, self._target)
            metadata = self._target.parent / "metadata.yaml"
            if not metadata.exists():
                os.replace(self._built / "metadata.yaml", metadata)
        else:
            os.replace(self._built, self._target)
        shutil.rmtree(self._building)

    def _write(self) -> None:
        while (item := self._queue.get()) is not None:
            try:
                self._write_one(item)
            except OSError as error:
                with self._lock:
                    self.failure = error.strerror or str(error)

    def _write_one(self, item: tuple[str, int, bytes] | Topic) -> None:
        if isinstance(item, Topic):
            self._connections[item.name] = self._writer.add_connection(
                item.name, item.message_type, typestore=installed_types(), offered_qos_profiles=item.qos
            )
            return
        topic, time, data = item
        with self._lock:
            self._waiting -= len(data)
        if not self.failure:
            self._writer.write(self._connections[topic], time, data)
            self.messages += 1
