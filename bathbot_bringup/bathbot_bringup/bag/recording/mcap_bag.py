"""A rosbag2 bag: topics and messages in one MCAP file, alone or in a folder with its metadata."""

import json
import shutil
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from bathbot_depthcorr.bounded_files import parse_yaml
from rosbags.interfaces import Qos
from rosbags.rosbag2.metadata import dump_qos_v9

from bathbot_bringup.bag.message_types import installed_types
from bathbot_bringup.bag.reading import NOTES
from bathbot_bringup.bag.recording.chunk_writer import ChunkWriter
from bathbot_bringup.bag.recording.steady_file import SteadyFile
from bathbot_bringup.errors import BagError

_VERSION = 9  # of rosbag2's metadata
_COUNTS = 0xFFFFFFFF  # what a sequence number of MCAP can hold
_AT_ONCE = 4 << 20  # [bytes] that may wait in memory


class Source(NamedTuple):
    """Where messages come from: a resolved name, and a type such as `std_msgs/msg/Header`."""

    topic: str
    message_type: str


class Topic(NamedTuple):
    """A source to record, and the quality of service it is offered with."""

    source: Source
    qos: Sequence[Qos]


class Stored(NamedTuple):
    """A message to store."""

    source: Source
    time: int  # received [ns]
    data: bytes  # CDR
    published: int = 0  # by its publisher's clock [ns]; 0: it is not known
    number: int = 0  # its publisher's count; 0: it is not known


def refuse_existing(target: Path) -> None:
    """Make sure that nothing is overwritten.

    Raises:
        BagError: When the target exists.
    """
    if target.exists():
        raise BagError(f"{target} exists already and is not overwritten; choose another name or remove it")


def remove_bag(target: Path) -> None:
    """Remove a bag of ours, and what describes nothing else."""
    if target.is_dir():
        shutil.rmtree(target)
        return
    target.unlink(missing_ok=True)
    described = target.with_name("metadata.yaml")
    with suppress(OSError, ValueError, KeyError):  # then it is not ours
        about = json.loads(described.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        if about["relative_file_paths"] == [target.name]:
            described.unlink()


class McapBag:
    """Writes a bag at `target`: a folder, or a single file when the name ends in `.mcap`.

    The folder of a single file becomes a bag, too, unless it is one already. It lies there from the
    beginning, is readable at any moment, and is open to this user only.

    Attributes:
        counts: Messages by source.
    """

    def __init__(self, target: Path, notes: dict[str, str]) -> None:
        """Begin the bag.

        Args:
            target: Where it shall lie.
            notes: Custom data for the metadata, such as the privacy profile.

        Raises:
            BagError: When the target exists or its folder cannot be written.
        """
        refuse_existing(target)
        single = target.suffix == ".mcap"
        file = target if single else target / f"{target.name}.mcap"
        self._name, self._described = file.name, file.with_name("metadata.yaml")
        self._notes, self._channels = dict[str, str](), dict[Source, int]()
        self._about, self.counts = dict[Source, dict[str, str]](), dict[Source, int]()
        self._offers: dict[Source, Any] = {}
        self._first, self._last = 2**63 - 1, 0  # [ns]
        try:
            file.parent.mkdir(mode=0o700, parents=True, exist_ok=single)
            self._own = not self._described.exists()  # or it tells of another bag
            self._file = SteadyFile(file)
            self._writer = ChunkWriter(self._file, "bathbot")
            self.note(notes)
            self.sync()
        except OSError as error:
            if not single:
                with suppress(OSError):  # it is not there, or holds something already
                    file.parent.rmdir()
            raise BagError(
                f"cannot write a bag at {target}: {error.strerror}; choose another place"
            ) from error

    def note(self, notes: dict[str, str]) -> None:
        """Add to what the metadata say of the bag."""
        self._notes |= notes
        self._writer.add_metadata(NOTES, self._notes)

    def add(self, topic: Topic) -> None:
        """Announce a topic before its first message."""
        types = installed_types()
        kind = topic.source.message_type
        definition, _ = types.generate_msgdef(kind, ros_version=2)
        about = {
            "offered_qos_profiles": json.dumps(dump_qos_v9(list(topic.qos))),
            "topic_type_hash": types.hash_rihs01(kind),
        }
        self.add_defined(topic.source, "ros2msg", definition.encode(), about)

    def add_defined(self, source: Source, encoding: str, definition: bytes, about: dict[str, str]) -> None:
        """Announce a topic whose type need not be installed.

        Args:
            source: Its name and type.
            encoding: Language of the definition, such as `ros2msg`.
            definition: Of the type.
            about: Of the channel: `offered_qos_profiles` as YAML, `topic_type_hash`.

        Raises:
            yaml.YAMLError: When the offers are no YAML, or more than they should be.
        """
        offers = parse_yaml(about.get("offered_qos_profiles", "[]"))
        schema = self._writer.add_schema(source.message_type, encoding, definition)
        self._channels[source] = self._writer.add_channel(source.topic, schema, about)
        self._about[source], self.counts[source] = about, 0
        self._offers[source] = offers

    def write(self, message: Stored) -> None:
        """Store a message of a topic that was announced.

        Raises:
            OSError: When what waits, this one included, cannot be written; it waits on.
        """
        self.counts[message.source] += 1
        self._writer.add_message(
            self._channels[message.source], message.time, message.published or message.time,
            (message.number or self.counts[message.source]) & _COUNTS, message.data,
        )  # fmt: skip
        self._first, self._last = min(self._first, message.time), max(self._last, message.time)
        if self._file.waiting > _AT_ONCE:
            self._file.flush()

    def sync(self) -> None:
        """Make all so far part of the bag, on the disk.

        Raises:
            OSError: When it cannot be written; the bag is as it was before.
        """
        self._writer.flush()
        self._file.sync()
        self._describe()

    def close(self) -> None:
        """Write the index and end the bag.

        Raises:
            OSError: When it cannot be written; the bag is as it was before, without an index.
        """
        self._writer.finish()
        self._file.close()
        self._describe()

    def abandon(self) -> None:
        """End the bag as it lies, without an index."""
        self._file.abandon()

    def _describe(self) -> None:
        if self._own:
            building = self._described.with_name(f".{self._described.name}")
            building.touch(mode=0o600)
            building.write_text(json.dumps(self._metadata(), indent=1), encoding="utf-8")  # is YAML, too
            building.replace(self._described)

    def _metadata(self) -> dict[str, Any]:
        held = sum(self.counts.values())
        extent = {
            "duration": {"nanoseconds": max(self._last - self._first, 0)},
            "starting_time": {"nanoseconds_since_epoch": self._first},
            "message_count": held,
        }
        return {
            "rosbag2_bagfile_information": {
                "version": _VERSION,
                "storage_identifier": "mcap",
                "relative_file_paths": [self._name],
                **extent,
                "topics_with_message_count": [
                    {
                        "topic_metadata": {
                            "name": source.topic,
                            "type": source.message_type,
                            "serialization_format": "cdr",
                            "offered_qos_profiles": self._offers[source],
                            "type_description_hash": about.get("topic_type_hash", ""),
                        },
                        "message_count": self.counts[source],
                    }
                    for source, about in self._about.items()
                ],
                "compression_format": "",
                "compression_mode": "",
                "files": [{"path": self._name, **extent}],
                "custom_data": self._notes,
                "ros_distro": "jazzy",
            }
        }
