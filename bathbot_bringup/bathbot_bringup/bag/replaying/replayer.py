"""Which topics of a bag to publish again, and when each message is due."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from rosbags.interfaces import Connection, Qos

from bathbot_bringup.bag.reading import open_bag, stored
from bathbot_bringup.errors import BagError

PICTURES = ("color/image_raw", "depth/image_rect_raw")
_MADE_BY_PIPELINE = (
    "depth/corrected/image", "depth/corrected/image_mm", "depth/corrected/camera_info",
    "depth/corrected/depth_to_color", "skin_regions", "skin_regions/label_info", "contact_targets", "surface",
    "scrub_segments", "planned_path",
)  # fmt: skip
CLOCK_STEP = 5_000_000
"""Least recorded time between two messages on /clock [ns]."""
_LOOK_EVERY, _TIME_TO_FOLLOW = 0.1, 1.0  # [s] between looks for listeners, and for others to follow the first
LONGEST_PAUSE = 3600.0
"""Between two messages [s]; beyond it somebody has set the clock."""
_LAST = 2**31 * 10**9  # [ns] that a time of ROS can tell
_NEVER = ("/clock", "/rosout", "/parameter_events", "/diagnostics")


class ReplayTopic(NamedTuple):
    """A topic to publish: name, type, number of messages, and how it was offered."""

    name: str
    message_type: str
    messages: int
    qos: Qos | None


class Message(NamedTuple):
    """A serialised message and when it was recorded [ns]."""

    topic: str
    time: int
    data: bytes


def has_pictures(names: Sequence[str]) -> bool:
    """Tell whether colour and raw depth are among topics, in any namespace."""
    return all(any(name.endswith(f"/{picture}") for name in names) for picture in PICTURES)


def choose_topics(bag: Path, sources_only: bool) -> list[ReplayTopic]:
    """Choose what to publish.

    With pictures in the bag, what the pipeline makes from them is left out, so that it is made anew;
    without, everything is published. Logs, diagnostics and the clock are never published again.

    Args:
        bag: To read.
        sources_only: False publishes the pipeline's topics too.

    Raises:
        BagError: When the bag cannot be read or holds nothing to publish.
    """
    with open_bag(bag) as reader:
        held = [c for c in reader.connections if c.msgcount and c.topic not in _NEVER]
        anew = sources_only and has_pictures([c.topic for c in held])
        chosen = [c for c in held if not (anew and _ends_with(c.topic, _MADE_BY_PIPELINE))]
        topics: dict[str, ReplayTopic] = {}
        for c in chosen:
            known = topics.get(c.topic, ReplayTopic(c.topic, c.msgtype, 0, next(iter(_qos(c)), None)))
            if known.message_type != c.msgtype:
                raise BagError(f"{c.topic} of {bag} is of two types, {known.message_type} and {c.msgtype}")
            topics[c.topic] = known._replace(messages=known.messages + c.msgcount)
    if not topics:
        raise BagError(
            f"bag {bag} holds no messages that could be published; was it recorded while the graph ran?"
        )
    return list(topics.values())


def counted(topics: Sequence[ReplayTopic]) -> list[ReplayTopic]:
    """Topics whose messages are all heard again to be counted; pictures would take too long."""
    return [topic for topic in topics if not topic.message_type.endswith("/Image")]


def lost(topics: Sequence[ReplayTopic], heard: Mapping[str, int]) -> dict[str, int]:
    """How many messages of each topic were not heard again; only topics that lack some."""
    lacking = {topic.name: topic.messages - heard.get(topic.name, 0) for topic in counted(topics)}
    return {name: number for name, number in lacking.items() if number > 0}


def _ends_with(topic: str, endings: Sequence[str]) -> bool:
    return any(topic == f"/{ending}" or topic.endswith(f"/{ending}") for ending in endings)


def _qos(connection: Connection) -> Sequence[Qos]:
    return getattr(connection.ext, "offered_qos_profiles", ())


def messages_of(bag: Path, topics: Sequence[ReplayTopic]) -> Iterator[Message]:
    """Give the messages of some topics in the order they were recorded, undecoded.

    Raises:
        BagError: When the bag cannot be read, or its clock was set while it was recorded.
    """
    names = {topic.name for topic in topics}
    with open_bag(bag) as reader:
        last: int | None = None
        for connection, stamp, data in stored(reader, [c for c in reader.connections if c.topic in names]):
            if not 0 <= stamp < _LAST:
                raise BagError(
                    f"a message of {bag} was received {stamp} ns after 1970, which is no time of ROS"
                )
            if last is not None and stamp - last > LONGEST_PAUSE * 1e9:
                raise BagError(
                    f"the clock of {bag} leaps by {(stamp - last) * 1e-9 / 3600:.1f} h between two messages; "
                    "was it set during the recording?"
                )
            last = stamp
            yield Message(connection.topic, stamp, bytes(data))


def pace(
    messages: Iterator[Message],
    rate: float,
    wait: Callable[[float], bool],
    now: Callable[[], float] = time.monotonic,
) -> Iterator[Message]:
    """Give each message when it is due.

    Args:
        messages: In order of time.
        rate: Speed; 2 is twice as fast as recorded.
        wait: Waits so many seconds; true ends the replay.
        now: A steady clock [s].
    """
    first: int | None = None
    begun = now()
    for message in messages:
        first = message.time if first is None else first
        due = begun + (message.time - first) * 1e-9 / rate
        if wait(max(due - now(), 0.0)):
            return
        yield message


class ClockHands:
    """Decides with which messages /clock moves: with the first, then in steps, and after a jump back."""

    def __init__(self) -> None:
        """Show nothing yet."""
        self._shown = 0

    def move(self, stamp: int) -> bool:
        """Whether the clock is to show `stamp` [ns]; it then does."""
        if 0 <= stamp - self._shown < CLOCK_STEP:
            return False
        self._shown = stamp
        return True


def wait_for_listeners(is_heard: Callable[[], bool], patience: float, wait: Callable[[float], bool]) -> None:
    """Let late listeners find the topics, so that the first pictures are not lost.

    Args:
        is_heard: Whether anybody listens; others get a second to follow.
        patience: Longest time to wait [s].
        wait: Waits so many seconds; true ends the replay.
    """
    waited = 0.0
    while waited < patience and not wait(_LOOK_EVERY):
        waited += _LOOK_EVERY
        if is_heard() and waited > _TIME_TO_FOLLOW:
            return
