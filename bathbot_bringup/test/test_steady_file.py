"""A bag whose writer is killed opens as it lies, whichever write was the last one to be done."""

import io
import os
import random
import signal
import subprocess
import sys

import pytest
from bathbot_bringup.bag.reading import summarise_bag
from bathbot_bringup.bag.recording import steady_file
from bathbot_bringup.bag.recording.mcap_bag import McapBag, Source, Stored, Topic
from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader

CLOCK = Source("/clock", "rosgraph_msgs/msg/Clock")
WRITER = """
import sys, time
from pathlib import Path
from bathbot_bringup.bag.recording.mcap_bag import McapBag, Source, Stored, Topic
source = Source("/clock", "rosgraph_msgs/msg/Clock")
bag = McapBag(Path(sys.argv[1]), {})
bag.add(Topic(source, []))
print("begun", flush=True)
for number in range(10**9):
    bag.write(Stored(source, number + 1, number.to_bytes(12, "little") + bytes(3000)))
    if number % 100 == 0:
        bag.sync()
        print(number + 1, flush=True)
"""


def numbers(data):
    """Of the messages in the bytes of a file, read from its beginning; it must end as a file should."""
    assert data.endswith(steady_file._MAGIC)
    records = StreamReader(io.BytesIO(data), validate_crcs=True).records
    return [record.sequence for record in records if type(record).__name__ == "Message"]


@pytest.mark.parametrize("seed", range(3))
def test_every_state_between_two_writes_is_a_whole_file(tmp_path, monkeypatch, seed):
    rng, states, really, file = random.Random(seed), [], os.pwrite, tmp_path / "run.mcap"
    monkeypatch.setattr(steady_file, "_GROWTH", 3000)

    def pwrite(descriptor, data, at):
        pages = [size for size in range(1, len(data)) if (at + size) % 4096 == 0]
        for size in [*pages, len(data)]:  # a writer can be killed after each page
            really(descriptor, data[:size], at)
            if file.exists():
                states.append(file.read_bytes())
        return len(data)

    monkeypatch.setattr(os, "pwrite", pwrite)
    bag, held = McapBag(file, {"about": "a test"}), []
    bag.add(Topic(CLOCK, []))
    for step in range(40):
        for number in range(10):
            bag.write(Stored(CLOCK, 10 * step + number + 1, bytes(rng.randrange(900))))
        bag.sync()
        held += [(state, {10 * step, 10 * step + 10}) for state in states]
        states.clear()
    bag.close()
    held += [(state, {400}) for state in states]
    assert len(held) > 150
    for state, allowed in held:
        found = numbers(state)
        assert found == [*range(1, len(found) + 1)]
        assert len(found) in allowed
    summary = make_reader(io.BytesIO(file.read_bytes())).get_summary()
    assert summary.statistics.message_count == 400


def test_a_bag_that_nobody_closed_can_be_read_by_others(tmp_path):
    bag = McapBag(tmp_path / "run", {})
    bag.add(Topic(CLOCK, []))
    for number in range(100):
        bag.write(Stored(CLOCK, number + 1, bytes(12)))
    bag.sync()
    for path in (tmp_path / "run", tmp_path / "run" / "run.mcap"):
        with AnyReader([path]) as reader:
            assert len(list(reader.messages())) == 100
        assert [topic.messages for topic in summarise_bag(path)] == [100]
    bag.abandon()


@pytest.mark.graph
def test_a_killed_writer_loses_nothing_that_was_synced(tmp_path):
    rng = random.Random(5)
    for attempt in range(6):
        target = tmp_path / f"{attempt}.mcap"
        command = [sys.executable, "-c", WRITER, str(target)]
        writer = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert writer.stdout.readline() == "begun\n"
        for _ in range(rng.randrange(40)):
            writer.stdout.readline()
        writer.send_signal(signal.SIGKILL)
        said = writer.stdout.read().split()
        writer.wait()
        found = numbers(target.read_bytes())
        assert found == [*range(1, len(found) + 1)]
        assert len(found) >= int(said[-1] if said else 0)
        assert summarise_bag(target)[0].messages == len(found)
