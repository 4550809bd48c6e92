"""A small file that would unfold to gigabytes is refused before anybody unfolds it."""

import struct
import tracemalloc

import lz4.frame
import pytest
import zstandard
from bags import write_bag
from bathbot_bringup.bag import bombs
from bathbot_bringup.bag.bombs import refuse_bombs
from bathbot_bringup.bag.reading import summarise_bag
from bathbot_bringup.bag.repair import repair_bag
from bathbot_bringup.errors import BagError
from rosgraph_msgs.msg import Clock

GIGABYTE = 1 << 30
ROW = ("/clock", "rosgraph_msgs/msg/Clock", 1, Clock())


def bomb(compression, told):
    """A chunk whose content is a gigabyte of zeros, and which tells whatever it likes of that."""
    if compression == b"zstd":
        maker = zstandard.ZstdCompressor(level=1, write_content_size=False).compressobj()
        data = b"".join(maker.compress(bytes(1 << 24)) for _ in range(64)) + maker.flush()
    else:
        with lz4.frame.LZ4FrameCompressor() as maker:
            data = maker.begin() + b"".join(maker.compress(bytes(1 << 24)) for _ in range(64)) + maker.flush()
    body = struct.pack("<QQQII", 1, 1, told, 0, len(compression)) + compression
    body += struct.pack("<Q", len(data)) + data
    return struct.pack("<BQ", 0x06, len(body)) + body


@pytest.fixture
def whole(tmp_path):
    return write_bag(tmp_path / "run.mcap", [ROW])


@pytest.mark.parametrize("compression", [b"zstd", b"lz4"])
@pytest.mark.parametrize("told", [GIGABYTE, 1000], ids=["open", "hidden"])
def test_a_chunk_of_a_gigabyte_is_refused(whole, compression, told):
    data = whole.read_bytes()
    whole.write_bytes(data[:-8] + bomb(compression, told) + data[-8:])
    for look in (refuse_bombs, summarise_bag, lambda bag: repair_bag(bag, bag.with_name("again"))):
        with pytest.raises(BagError, match="unfolds to more than 256 MB"):
            look(whole)


def test_what_is_plain_or_damaged_passes(whole):
    refuse_bombs(whole)
    data = whole.read_bytes()
    for cut in range(0, len(data), 7):
        whole.write_bytes(data[:cut])
        refuse_bombs(whole)


@pytest.mark.timeout(20)
def test_a_file_of_nothing_or_of_tiny_records_hangs_nobody(tmp_path, monkeypatch):
    hole = tmp_path / "hole.mcap"
    with hole.open("wb") as file:
        file.write(b"\x89MCAP0\r\n")
        file.truncate(8 << 30)
    refuse_bombs(hole)
    monkeypatch.setattr(bombs, "_MOST_RECORDS", 1000)
    (tmp_path / "tiny.mcap").write_bytes(b"\x89MCAP0\r\n" + struct.pack("<BQ", 0x80, 0) * 1001)
    with pytest.raises(BagError, match="more than 1000 records"):
        refuse_bombs(tmp_path / "tiny.mcap")


def test_it_takes_little_memory_to_find_out(whole):
    data = whole.read_bytes()
    whole.write_bytes(data[:-8] + bomb(b"zstd", 1000) + data[-8:])
    tracemalloc.start()
    try:
        with pytest.raises(BagError):
            refuse_bombs(whole)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 32 << 20
