"""What can be read of a bag is written anew: all of one that nobody closed, the rest of a damaged one."""

import os
from itertools import pairwise

import pytest
from bags import write_bag
from bathbot_bringup.bag.reading import read_messages, summarise_bag
from bathbot_bringup.bag.recording.mcap_bag import McapBag, Source, Stored, Topic
from bathbot_bringup.bag.repair import repair_bag
from bathbot_bringup.errors import BagError
from builtin_interfaces.msg import Time
from mcap.reader import make_reader
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock

MAGIC = b"\x89MCAP0\r\n"
CLOCK = Source("/clock", "rosgraph_msgs/msg/Clock")


def unfinished(target, count=100):
    bag = McapBag(target, {"privacy_profile": "metrics_only"})
    bag.add(Topic(CLOCK, []))
    for number in range(count):
        data = serialize_message(Clock(clock=Time(sec=number)))
        bag.write(Stored(CLOCK, number + 1, data))
        if number % 10 == 9:
            bag.sync()
    bag.abandon()
    return target


def seconds(bag):
    return [entry.message.clock.sec for entry in read_messages(bag, ("clock",))]


@pytest.mark.parametrize("name", ["run", "run.mcap"])
def test_a_bag_that_nobody_closed_gets_an_index(tmp_path, name):
    again = tmp_path / f"again_{name}"
    assert repair_bag(unfinished(tmp_path / name), again) == (100, 0, "")
    assert seconds(again) == list(range(100))
    file = again / f"again_{name}.mcap" if again.is_dir() else again
    with file.open("rb") as opened:
        reader = make_reader(opened, validate_crcs=True)
        assert reader.get_summary().statistics.message_count == 100
        assert [one.metadata for one in reader.iter_metadata()][-1] == {
            "privacy_profile": "metrics_only",
            "repaired": "yes",
        }


def test_of_a_file_that_ends_too_early_all_before_is_there(tmp_path):
    whole = write_bag(tmp_path / "run.mcap", [
        (*CLOCK, number + 1, Clock(clock=Time(sec=number))) for number in range(100)
    ])  # fmt: skip
    closed = unfinished(tmp_path / "cut.mcap")
    os.truncate(closed, 3000)
    done = repair_bag(closed, tmp_path / "again")
    assert 0 < done.messages < 100
    assert done.trouble
    assert seconds(tmp_path / "again") == list(range(done.messages))
    assert seconds(whole) == list(range(100))


def test_a_flipped_byte_costs_its_chunk(tmp_path):
    damaged = unfinished(tmp_path / "run.mcap")
    data = bytearray(damaged.read_bytes())
    data[3000] ^= 0x10
    damaged.write_bytes(data)
    done = repair_bag(damaged, tmp_path / "again")
    assert done.damaged >= 1
    assert 0 < done.messages < 100
    assert set(seconds(tmp_path / "again")) < set(range(100))


@pytest.mark.parametrize("content", [b"", MAGIC, MAGIC + bytes(1000), b"no bag" * 9])
def test_what_is_no_bag_is_said_and_leaves_nothing(tmp_path, content):
    (tmp_path / "run.mcap").write_bytes(content)
    with pytest.raises(BagError, match="nothing can be read"):
        repair_bag(tmp_path / "run.mcap", tmp_path / "again")
    with pytest.raises(BagError, match="nothing can be read"):
        repair_bag(tmp_path / "run.mcap", tmp_path / "again.mcap")
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap"]


def test_nothing_to_repair_is_said(tmp_path):
    with pytest.raises(BagError, match="neither an"):
        repair_bag(tmp_path / "none", tmp_path / "again")
    with pytest.raises(BagError, match="exists already"):
        repair_bag(unfinished(tmp_path / "run"), tmp_path / "run")
    assert summarise_bag(tmp_path / "run")


def test_offers_of_a_stranger_that_unfold_to_gigabytes_are_damage(tmp_path):
    bag = McapBag(tmp_path / "run", {})
    words = "".join(
        f", &{name} [*{before}, *{before}]" for before, name in pairwise("abcdefghijklmnopqrstuvwxyz")
    )
    bomb = f"[&a [1, 1]{words}]"
    writer = bag._writer
    schema = writer.add_schema(CLOCK.message_type, "ros2msg", b"builtin_interfaces/Time clock")
    writer.add_message(
        writer.add_channel(CLOCK.topic, schema, {"offered_qos_profiles": bomb}), 1, 1, 1, bytes(12)
    )
    bag.sync()
    bag.abandon()
    with pytest.raises(BagError, match="unfolds to more than"):
        repair_bag(tmp_path / "run", tmp_path / "again")
    assert not (tmp_path / "again").exists()
