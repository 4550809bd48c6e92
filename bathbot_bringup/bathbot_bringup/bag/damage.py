"""MCAP files whose bytes are not those that were written; readers look at few of the sums that tell."""

import struct
import zlib
from collections import defaultdict
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Chunk, Footer, MessageIndex
from mcap.stream_reader import StreamReader, get_chunk_data_stream

from bathbot_bringup.bag.bombs import LARGEST
from bathbot_bringup.errors import BagError

_HEAD, _MESSAGE = struct.Struct("<BQ"), struct.Struct("<HIQ")
_TAIL = 4 + 8  # [bytes] of the sum over the summary, and of what ends a file

Index = dict[int, list[tuple[int, int]]]
"""Time [ns] and offset in its chunk of each message, by its channel."""


def refuse_damaged(file: Path) -> None:
    """Read a file from beginning to end and compare every sum and every index with what is there.

    Raises:
        BagError: When they differ.
        Exception: Of any kind, from the parser, when it is damaged otherwise.
    """
    held: Index = {}
    told: Index = {}
    with file.open("rb") as opened:
        for record in StreamReader(opened, emit_chunks=True, record_size_limit=LARGEST).records:
            if isinstance(record, MessageIndex):
                told |= {record.channel_id: sorted(record.records)} if record.records else {}
                continue
            if told and told != held:
                raise BagError(f"{file} is damaged: an index does not fit its chunk")
            held, told = _messages(record) if isinstance(record, Chunk) else {}, {}
            footer = record if isinstance(record, Footer) else None
        if footer is not None and footer.summary_start and footer.summary_crc:
            opened.seek(footer.summary_start)
            if zlib.crc32(opened.read()[:-_TAIL]) != footer.summary_crc:
                raise BagError(f"{file} is damaged: the summary at its end is not what was written")


def _messages(chunk: Chunk) -> Index:
    """Where the messages of a chunk are, by what it holds itself.

    Raises:
        CRCValidationError: When it holds something else than what was written.
    """
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    content, at = stream.read(length), 0
    found: Index = defaultdict(list)
    while at < length:
        kind, size = _HEAD.unpack_from(content, at)
        if kind == Opcode.MESSAGE:
            channel, _, time = _MESSAGE.unpack_from(content, at + _HEAD.size)
            found[channel].append((time, at))
        at += _HEAD.size + size
    return {channel: sorted(messages) for channel, messages in found.items()}
