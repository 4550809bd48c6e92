"""Messages of a rosbag2 recording; needs no ROS."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from bathbot_depthcorr.errors import BathbotError, DepthcorrError


class BagError(DepthcorrError):
    """A recording that is unreadable or lacks what a calibration needs."""


def is_bag(path: Path) -> bool:
    """Whether a path is a rosbag2 folder, whatever else lies in it, or an MCAP file."""
    return (path / "metadata.yaml").is_file() if path.is_dir() else path.suffix == ".mcap"


def messages(bag: Path, *topics: str) -> Iterator[tuple[str, Any]]:
    """Topic and message, in order of time, of a recording.

    Raises:
        BagError: If the bag is missing, cut off or damaged.
    """
    try:
        with AnyReader([Path(bag)], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
            wanted = [connection for connection in reader.connections if connection.topic in topics]
            for connection, _, raw in reader.messages(wanted) if wanted else ():
                yield connection.topic, reader.deserialize(raw, connection.msgtype)
    except BathbotError:
        raise
    except Exception as error:  # a damaged file leads the parser to errors of any kind
        raise _unreadable(bag, error) from error


def message_counts(bag: Path) -> dict[str, int]:
    """Number of messages of every topic of a recording.

    Raises:
        BagError: If the bag is missing, cut off or damaged.
    """
    try:
        with AnyReader([Path(bag)], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
            counts: dict[str, int] = {}
            for connection in reader.connections:
                counts[connection.topic] = counts.get(connection.topic, 0) + connection.msgcount
            return counts
    except Exception as error:  # as above
        raise _unreadable(bag, error) from error


def _unreadable(bag: Path, error: Exception) -> BagError:
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    return BagError(
        f"cannot read bag {bag}: {reason}; is it complete (ros2 bag reindex repairs a cut-off one)?"
    )
