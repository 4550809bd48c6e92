"""Reading bags without ROS: rosbag2 folders and single MCAP files."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from bathbot_depthcorr.ros.bag_messages import is_bag
from mcap.exceptions import McapError
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection

from bathbot_bringup.bag.bombs import refuse_bombs
from bathbot_bringup.errors import BagError

NOTES = "bathbot"
"""Name of our metadata in a file."""


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
def open_bag(path: Path) -> Iterator[AnyReader]:
    """Open a bag for reading.

    Raises:
        BagError: When there is none, or it is broken.
    """
    if not path.exists():
        raise BagError(f"there is no bag {path}; give a rosbag2 folder or an .mcap file")
    if path.is_dir() and not is_bag(path):
        raise BagError(f"{path} is a folder without metadata.yaml, so no rosbag2 bag; name the bag inside it")
    try:
        for file in path.glob("*.mcap") if path.is_dir() else [path]:
            refuse_bombs(file)
        reader = AnyReader([path])
        reader.open()
    except (AnyReaderError, OSError, ValueError, KeyError, AssertionError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise BagError(f"cannot read {path} as a bag: {reason}; `bathbot repair` may help") from error
    try:
        yield reader
    finally:
        reader.close()


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
    for file in sorted(path.glob("*.mcap")) if path.is_dir() else [path]:
        try:
            refuse_bombs(file)
            with file.open("rb") as opened:
                for record in make_reader(opened).iter_metadata():
                    notes |= record.metadata if record.name == NOTES else {}
        except (McapError, OSError, ValueError) as error:
            raise BagError(f"cannot read {path} as a bag: {error}; `bathbot repair` may help") from error
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
    with open_bag(path) as reader:
        connections = connections_ending(reader, endings)
        for connection, time, data in reader.messages(connections) if connections else ():  # none means all
            yield Entry(connection.topic, time, reader.deserialize(data, connection.msgtype))


def bag_length(path: Path) -> float:
    """Time between the first and the last message of a bag [s].

    Raises:
        BagError: When it cannot be read.
    """
    with open_bag(path) as reader:
        return reader.duration * 1e-9 if reader.message_count else 0.0
