"""Bags that tests make themselves."""

from bathbot_bringup.bag.recording.mcap_bag import McapBag, Source, Stored, Topic
from rclpy.serialization import serialize_message


def write_bag(target, rows, kinds=(), **notes):
    """Of rows of topic, type, time [ns] and message; `kinds` are topics and types without any."""
    bag, known = McapBag(target, notes), set()
    for source in [Source(*kind) for kind in kinds] + [Source(topic, kind) for topic, kind, _, _ in rows]:
        if source not in known:
            bag.add(Topic(source, []))
            known.add(source)
    for topic, kind, time, message in rows:
        bag.write(Stored(Source(topic, kind), time, serialize_message(message)))
    bag.close()
    return target
