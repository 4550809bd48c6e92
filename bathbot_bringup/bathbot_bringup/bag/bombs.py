"""MCAP files from strangers: a few bytes in a chunk can stand for gigabytes that a reader unfolds at once."""

import struct
from pathlib import Path
from typing import BinaryIO

import lz4.frame
import zstandard

from bathbot_bringup.errors import BagError

LARGEST = 256 << 20
"""What a chunk may unfold to [bytes]."""
_HEAD, _CHUNK_START, _LENGTH = struct.Struct("<BQ"), struct.Struct("<QQQII"), struct.Struct("<Q")
_MAGIC, _NO_KIND, _CHUNK = b"\x89MCAP0\r\n", 0x00, 0x06
_MOST_RECORDS = 2_000_000  # ten gigabytes of chunks of 1 MB have a tenth of that
_FRAME = 18  # [bytes] of the head of a zstd or lz4 frame
_PIECE = 1 << 20  # [bytes]


def refuse_bombs(file: Path) -> None:
    """Look at the head of every chunk, without unfolding any that tells its size.

    Raises:
        BagError: When one unfolds to more than 256 MB, or the file has millions of records.
        OSError: When the file cannot be read.
    """
    size = file.stat().st_size
    with file.open("rb") as opened:
        at, records = len(_MAGIC), 0
        while at + _HEAD.size <= size and records <= _MOST_RECORDS:
            opened.seek(at)
            kind, length = _HEAD.unpack(opened.read(_HEAD.size))
            if kind == _NO_KIND:
                return  # from here on it is no MCAP file; whoever reads it says so
            records += 1
            if kind == _CHUNK and at + _HEAD.size + length <= size:
                unfolded = _unfolded(opened)
                if unfolded > LARGEST:
                    raise BagError(
                        f"{file} has a chunk that unfolds to more than {LARGEST >> 20} MB, at byte {at}; "
                        "bags of ours have chunks of 1 MB"
                    )
            at += _HEAD.size + length
    if records > _MOST_RECORDS:
        raise BagError(f"{file} has more than {_MOST_RECORDS} records outside of chunks; no bag of ours has")


def _unfolded(opened: BinaryIO) -> int:
    """Bytes that a chunk unfolds to, counted up to a little more than is allowed."""
    head = opened.read(_CHUNK_START.size)
    if len(head) < _CHUNK_START.size:
        return 0
    _, _, told, _, characters = _CHUNK_START.unpack(head)
    compression = opened.read(min(characters, 16))
    length = opened.read(_LENGTH.size)
    if characters > 16 or len(length) < _LENGTH.size or told > LARGEST:
        return told
    begun, compressed = opened.tell(), _LENGTH.unpack(length)[0]
    frame = opened.read(_FRAME)
    try:
        if compression == b"zstd" and zstandard.frame_content_size(frame) == told:
            return told
        if compression == b"lz4" and lz4.frame.get_frame_info(frame)["content_size"] == told:
            return told
        opened.seek(begun)
        return _counted(opened.read(compressed), compression) if compression else told
    except (zstandard.ZstdError, RuntimeError):
        return told  # it is damaged; whoever reads it says so


def _counted(data: bytes, compression: bytes) -> int:
    """Unfold piece by piece, keeping nothing."""
    if compression == b"zstd":
        total = 0
        for piece in zstandard.ZstdDecompressor().read_to_iter(data, write_size=_PIECE):
            total += len(piece)
            if total > LARGEST:
                break
        return total
    total, unfolder = 0, lz4.frame.LZ4FrameDecompressor()
    piece = unfolder.decompress(data, max_length=_PIECE)
    while piece and total <= LARGEST:
        total += len(piece)
        piece = b"" if unfolder.eof else unfolder.decompress(b"", max_length=_PIECE)
    return total
