"""The writer of MCAP files, judged by the library's reader."""

import io

import numpy as np
from bathbot_bringup.bag.recording.chunk_writer import ChunkWriter
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader

SIZES = st.sampled_from([0, 1, 500, 70_000, 400_000])
MESSAGES = st.lists(st.tuples(st.integers(0, 2), st.integers(1, 2**62), SIZES), max_size=20)


def content(size, seed):
    return np.random.default_rng(seed).integers(0, 256, size, np.uint8).tobytes()


def written(messages, flush_every=10**9):
    file = io.BytesIO()
    writer = ChunkWriter(file, "a test")
    schema = writer.add_schema("std_msgs/msg/Byte", "ros2msg", b"byte data")
    channels = [writer.add_channel(f"/{name}", schema, {"about": name}) for name in "abc"]
    writer.add_metadata("bathbot", {"lost": "0"})
    for number, (channel, time, size) in enumerate(messages, 1):
        writer.add_message(channels[channel], time, time - 1, number, content(size, number))
        if number % flush_every == 0:
            writer.flush()
    writer.finish()
    file.seek(0)
    return file


@settings(deadline=None, max_examples=60)
@given(messages=MESSAGES, flush_every=st.integers(1, 5))
def test_another_reader_finds_all_by_its_index_and_without(messages, flush_every):
    file = written(messages, flush_every)
    expected = {
        (number, f"/{'abc'[channel]}", time, time - 1, content(size, number))
        for number, (channel, time, size) in enumerate(messages, 1)
    }
    reader = make_reader(file, validate_crcs=True)
    found = [
        (message.sequence, channel.topic, message.log_time, message.publish_time, message.data)
        for _, channel, message in reader.iter_messages()
    ]
    assert len(found) == len(messages)
    assert set(found) == expected
    assert [time for _, _, time, _, _ in found] == sorted(time for _, time, _ in messages)
    file.seek(0)
    records = StreamReader(file, validate_crcs=True).records
    numbers = [one.sequence for one in records if type(one).__name__ == "Message"]
    assert numbers == list(range(1, len(messages) + 1)), "who has no index needs them as they came"


def test_the_summary_tells_what_is_there():
    file = written([(0, 5, 10), (1, 3, 80_000), (0, 9, 10)])
    summary = make_reader(file, validate_crcs=True).get_summary()
    told = summary.statistics
    assert (told.message_count, told.message_start_time, told.message_end_time) == (3, 3, 9)
    assert told.channel_message_counts == {1: 2, 2: 1}
    assert {(chunk.compression, chunk.message_start_time) for chunk in summary.chunk_indexes} == {
        ("", 3),
        ("zstd", 5),
        ("zstd", 9),
    }
    assert [one.metadata for one in make_reader(file).iter_metadata()] == [{"lost": "0"}]


def test_only_one_topic_is_read_where_one_is_asked():
    file = written([(number % 3, number + 1, 500) for number in range(30)])
    assert {channel.topic for _, channel, _ in make_reader(file).iter_messages(["/b"])} == {"/b"}


def test_numbers_shrink():
    file = io.BytesIO()
    writer = ChunkWriter(file, "a test")
    channel = writer.add_channel("/a", writer.add_schema("a", "ros2msg", b""), {})
    for number in range(2000):
        writer.add_message(channel, number, number, number, bytes(500))
    writer.finish()
    assert len(file.getvalue()) < 200_000
