"""What is no bag, is damaged, or lies about itself ends in one error of ours; what is used was written so."""

import random
from contextlib import suppress

import pytest
from bad_bags import TICK, flipped, make_bags
from bags import write_bag
from bathbot_bringup.bag.reading import check_whole, notes_of, read_messages, summarise_bag
from bathbot_bringup.bag.repair import repair_bag
from bathbot_bringup.bag.replaying.replayer import choose_topics, messages_of
from bathbot_bringup.command.cli import run
from bathbot_bringup.errors import BagError
from builtin_interfaces.msg import Time

pytestmark = pytest.mark.timeout(120)  # none may hang its reader

REFUSED = {
    "empty": "seems to be empty",
    "cut_half": "cannot read",
    "schema_other": "another sensor_msgs/msg/Image than the one installed",
    "encoding_json": "is written as json",
    "twice_type": "is of two types",
    "time_huge": "no time of ROS",
    "jump_on": "leaps by 8760.0 h",
    "jump_back": "leaps by 8760.0 h",
    "folder_empty": "without metadata.yaml",
    "two_bags": "name the bag inside it",
    "fifo": "no plain file",
    "device": "no plain file",
}
BAD = ("empty", "magic", "two_magics", "text", "flipped_2", "schema_bytes", "folder_empty", "missing", "fifo")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return make_bags(tmp_path_factory.mktemp("made") / "bags")


def replayed(bag):
    """All that would be published."""
    check_whole(bag)
    return [(one.topic, one.time, one.data) for one in messages_of(bag, choose_topics(bag, True))]


def read(bag):
    """All that is said about colour pictures."""
    return list(read_messages(bag, ("color/image_raw",)))


@pytest.mark.parametrize(
    "look", [check_whole, replayed, read, summarise_bag, notes_of], ids=lambda one: one.__name__
)
def test_a_reader_reads_a_bag_or_refuses_it_by_name(made, look):
    refusals = {}
    for bag in made.values():
        try:
            look(bag)
        except BagError as error:
            refusals[bag] = str(error)
    assert all(str(bag) in said and len(said) < 500 for bag, said in refusals.items())
    assert made["whole"] not in refusals
    assert made["magic"] in refusals


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_replayed_is_refused_for_what_it_is(made, name):
    with pytest.raises(BagError, match=REFUSED[name]):
        replayed(made[name])


def test_messages_twice_are_replayed_twice(made):
    assert len(replayed(made["twice_channel"])) == 6
    assert len(replayed(made["twice_time"])) == 50
    assert [topic.messages for topic in choose_topics(made["twice_channel"], True)] == [6]


def test_a_flipped_bit_never_changes_what_is_replayed(tmp_path):
    rows = [("/t", TICK, 10**18 + number * 10**8, Time(sec=number)) for number in range(6)]
    whole = write_bag(tmp_path / "run.mcap", rows)
    good, data, refused, rng = replayed(whole), whole.read_bytes(), 0, random.Random(1)
    for at in range(8, len(data)):
        whole.write_bytes(data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :])
        try:
            assert replayed(whole) == good, f"byte {at}"
        except BagError:
            refused += 1
    assert refused > len(data) / 2


def test_repair_gives_a_bag_that_can_be_read_or_says_that_it_does_not(made, tmp_path):
    repaired = {}
    for name, bag in made.items():
        with suppress(BagError):
            repaired[name] = repair_bag(bag, tmp_path / name)
    for name, done in repaired.items():
        check_whole(tmp_path / name)
        assert done.messages == sum(topic.messages for topic in summarise_bag(tmp_path / name))
    assert {"whole", "cut_half", "cut_footer", "metadata_words", "two_files"} <= set(repaired)
    assert not {"magic", "text", "schema_words", "fifo"} & set(repaired)


def test_repair_of_any_damage_ends_in_a_bag_or_in_one_error(tmp_path):
    whole = write_bag(tmp_path / "run.mcap", [("/t", TICK, n + 1, Time(sec=n)) for n in range(6)])
    data, repaired = whole.read_bytes(), 0
    for seed in range(200):
        whole.write_bytes(data)
        flipped(whole, seed, count=1 + seed % 3)
        with suppress(BagError):
            repair_bag(whole, tmp_path / f"{seed}")
            repaired += 1
    assert 0 < repaired < 200


@pytest.mark.parametrize("command", [
    "calibrate depth --out x.npz", "calibrate hand-eye --out x.yaml", "detect --out x", "replay",
    "repair --out x",
])  # fmt: skip
def test_commands_say_one_line_and_leave_nothing(made, capsys, tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    for name in BAD:
        assert run([*command.split(), str(made[name])]) == 2, name
        assert len(capsys.readouterr().err.splitlines()) == 1, name
        assert not any(tmp_path.iterdir()), name
