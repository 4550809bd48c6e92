"""Reading bags without ROS: rosbag2 folders and single MCAP files.

Whatever a damaged or lying file leads a parser to ends as a `BagError` that names the bag.
"""

import textwrap
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from bathbot_depthcorr.errors import BathbotError
from bathbot_depthcorr.ros.bag_messages import is_bag
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.stream_reader import CRCValidationError
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection

from bathbot_bringup.bag.bombs import refuse_bombs
from bathbot_bringup.bag.damage import refuse_damaged
from bathbot_bringup.bag.message_types import installed_types
from bathbot_bringup.errors import BagError

NOTES = "bathbot"
"""Name of our metadata in a file."""
_TELLING = (AnyReaderError, McapError, CRCValidationError, OSError)
_WRITTEN = "serialization_format"


class TopicSummary(NamedTuple):
    """A topic of a bag."""

    name: str
    message_type: str
    messages: int


class Entry(NamedTuple):
    """One message: its topic, when it was recorded [ns], and what it says."""

    topic: str
    time: int
    message: Any


@contextmanager
def explained(path: Path) -> Iterator[None]:
    """Name the bag in any error of its parser."""
    try:
        yield
    except BathbotError:
        raise
    except Exception as error:  # a damaged file leads the parser to errors of any kind
        reason = textwrap.shorten(str(error), 200, placeholder=" ...").rstrip(".") or type(error).__name__
        if not isinstance(error, _TELLING):
            reason = f"it is damaged, or of an unknown kind ({reason})"
        raise BagError(f"cannot read {path} as a bag: {reason}; `bathbot repair` may help") from error


def _files(path: Path) -> list[Path]:
    """MCAP files of a bag.

    Raises:
        BagError: When there is none, or what is there could be waited for without end.
    """
    if not path.exists():
        raise BagError(f"there is no bag {path}; give a rosbag2 folder or an .mcap file")
    if path.is_dir() and not is_bag(path):
        raise BagError(f"{path} is a folder without metadata.yaml, so no rosbag2 bag; name the bag inside it")
    files = sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    for file in files:
        if not file.is_file():
            raise BagError(f"{file} is no plain file; give a rosbag2 folder or an .mcap file")
    return files


@contextmanager
def open_bag(path: Path) -> Iterator[AnyReader]:
    """Open a bag for reading.

    Raises:
        BagError: When there is none, or it is broken.
    """
    with explained(path):
        for file in _files(path):
            refuse_bombs(file)
        reader = AnyReader([path])
        reader.open()
    try:
        yield reader
    finally:
        reader.close()


def check_whole(path: Path) -> None:
    """Read a bag from beginning to end, before anything in it is believed.

    Raises:
        BagError: When it cannot be read, or its bytes are not those that were written.
    """
    with open_bag(path), explained(path):
        for file in _files(path):
            refuse_damaged(file)


def bag_bytes(path: Path) -> int:
    """Size of a bag on the disk.

    Raises:
        BagError: When there is none.
    """
    return sum(file.stat().st_size for file in _files(path))


def summarise_bag(path: Path) -> list[TopicSummary]:
    """List the topics of a bag, with their counts.

    Raises:
        BagError: When it cannot be read.
    """
    with open_bag(path) as reader:
        return sorted(TopicSummary(c.topic, c.msgtype, c.msgcount) for c in reader.connections)


def notes_of(path: Path) -> dict[str, str]:
    """What the recorder has written into a bag about it; empty for bags of others.

    Raises:
        BagError: When it cannot be read.
    """
    notes: dict[str, str] = {}
    with explained(path):
        for file in _files(path):
            refuse_bombs(file)
            with file.open("rb") as opened:
                for record in make_reader(opened).iter_metadata():
                    notes |= record.metadata if record.name == NOTES else {}
    return notes


def connections_ending(reader: AnyReader, endings: tuple[str, ...]) -> list[Connection]:
    """Find the connections whose topic is one of `endings`, in any namespace."""
    return [
        c for c in reader.connections if any(c.topic == f"/{e}" or c.topic.endswith(f"/{e}") for e in endings)
    ]


def read_messages(path: Path, endings: tuple[str, ...]) -> Iterator[Entry]:
    """Give the messages of some topics in the order they were recorded.

    Args:
        path: The bag.
        endings: Topic names without namespace, such as `arm_state`.

    Raises:
        BagError: When the bag cannot be read.
    """
    with open_bag(path) as reader, explained(path):
        for connection, time, data in stored(reader, connections_ending(reader, endings)):
            yield Entry(connection.topic, time, reader.deserialize(data, connection.msgtype))


def stored(reader: AnyReader, connections: Collection[Connection]) -> Iterator[tuple[Connection, int, bytes]]:
    """Give the messages of some connections of an open bag in order of their times [ns], undecoded.

    Raises:
        BagError: When they are not what the types installed here describe, or cannot be read.
    """
    with explained(reader.paths[0]):
        for connection in connections:
            _check_type(reader, connection)
        yield from reader.messages(connections) if connections else ()  # none means all


def _check_type(reader: AnyReader, connection: Connection) -> None:
    kind, installed, written = connection.msgtype, installed_types(), getattr(connection.ext, _WRITTEN, "cdr")
    if written != "cdr":
        raise BagError(f"{connection.topic} of {reader.paths[0]} is written as {written}, ROS 2 writes cdr")
    if kind in installed.fielddefs and reader.typestore.hash_rihs01(kind) != installed.hash_rihs01(kind):
        raise BagError(
            f"{connection.topic} of {reader.paths[0]} has another {kind} than the one installed here; was it "
            "recorded with another version?"
        )


def bag_length(path: Path) -> float:
    """Time between the first and the last message of a bag [s].

    Raises:
        BagError: When it cannot be read.
    """
    with open_bag(path) as reader:
        return reader.duration * 1e-9 if reader.message_count else 0.0
