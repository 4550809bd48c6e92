"""Writes the records of an MCAP file: numbers in compressed chunks, each picture in a chunk as it is.

The records are those of the library `mcap`. Its own writer copies each message five times and compresses all
or nothing: for pictures, which hardly shrink, that costs more than all else about their recording.
"""

import struct
import zlib
from collections import Counter, defaultdict
from typing import Protocol

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

_MAGIC = b"\x89MCAP0\r\n"
_MESSAGE = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, time of log and of publication
_CHUNK = struct.Struct("<BQQQQII")  # opcode, length, first and last time, size, CRC, length of the next text
_SIZE = struct.Struct("<Q")
_FOOTER = struct.Struct("<BQQQ")
_FULL = 1 << 20  # [bytes] of a chunk of small messages
_LARGE = 1 << 16  # [bytes] of a message that has a chunk of its own
_LEVEL = 1  # of zstd: higher ones gain little for numbers that change


Index = dict[int, list[tuple[int, int]]]
"""Of each channel, when its messages were recorded [ns] and where in the records of the chunk they lie."""


class Output(Protocol):
    """What the records go to."""

    def write(self, data: bytes) -> int:
        """Take bytes."""

    def tell(self) -> int:
        """Where the next ones will lie."""


class ChunkWriter:
    """Writes to `output`; nothing of a chunk is there before it is full or `flush` is called."""

    def __init__(self, output: Output, library: str) -> None:
        """Begin the file."""
        self._output = output
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: Counter[int] = Counter()
        self._first, self._last = 0, 0
        self._begin_chunk()
        output.write(_MAGIC + _bytes(Header(profile="ros2", library=library)))

    def add_schema(self, name: str, encoding: str, definition: bytes) -> int:
        """Add a type; its number."""
        made = Schema(id=len(self._schemas) + 1, name=name, encoding=encoding, data=definition)
        self._schemas.append(made)
        self._output.write(_bytes(made))
        return made.id

    def add_channel(self, topic: str, schema: int, about: dict[str, str]) -> int:
        """Add a topic of the type `schema`; its number."""
        made = Channel(
            id=len(self._channels) + 1, topic=topic, message_encoding="cdr", metadata=about, schema_id=schema
        )
        self._channels.append(made)
        self._output.write(_bytes(made))
        return made.id

    def add_metadata(self, name: str, said: dict[str, str]) -> None:
        """Add what is to be said of the file."""
        record = _bytes(Metadata(name=name, metadata=said))
        self._metadata.append(MetadataIndex(offset=self._output.tell(), length=len(record), name=name))
        self._output.write(record)

    def add_message(self, channel: int, time: int, published: int, number: int, data: bytes) -> None:
        """Add a message.

        Args:
            channel: Number of its topic.
            time: Of its recording [ns].
            published: When it was sent [ns].
            number: Its publisher's count, of 32 bits.
            data: CDR.
        """
        self._first = min(self._first, time) if self._counts.total() else time
        self._last = max(self._last, time)
        self._counts[channel] += 1
        head = _MESSAGE.pack(Opcode.MESSAGE, _MESSAGE.size - 9 + len(data), channel, number, time, published)
        if len(data) >= _LARGE:
            self.flush()  # who reads without the index needs the messages as they came
            self._write_chunk([head, data], {channel: [(time, 0)]}, "", [head, data])
            return
        self._index[channel].append((time, self._size))
        self._pieces += (head, data)
        self._size += len(head) + len(data)
        if self._size >= _FULL:
            self.flush()

    def flush(self) -> None:
        """Write what was begun."""
        if self._pieces:
            compressor = zstandard.ZstdCompressor(level=_LEVEL)
            whole = b"".join(self._pieces)
            self._write_chunk([whole], self._index, "zstd", [compressor.compress(whole)])
            self._begin_chunk()

    def finish(self) -> None:
        """Write the index and end the file."""
        self.flush()
        self._output.write(_bytes(DataEnd(0)))
        start, groups, offsets = self._output.tell(), b"", b""
        for opcode, records in (
            (Opcode.SCHEMA, self._schemas),
            (Opcode.CHANNEL, self._channels),
            (Opcode.STATISTICS, [self._statistics()]),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.METADATA_INDEX, self._metadata),
        ):
            group = b"".join(map(_bytes, records))
            offsets += _bytes(
                SummaryOffset(group_opcode=opcode, group_start=start + len(groups), group_length=len(group))
            )
            groups += group
        checked = groups + offsets + _FOOTER.pack(Opcode.FOOTER, 20, start, start + len(groups))
        footer = Footer(
            summary_start=start, summary_offset_start=start + len(groups), summary_crc=zlib.crc32(checked)
        )
        self._output.write(groups + offsets + _bytes(footer) + _MAGIC)

    def _begin_chunk(self) -> None:
        self._pieces: list[bytes] = []
        self._size = 0
        self._index: Index = defaultdict(list)

    def _write_chunk(self, pieces: list[bytes], index: Index, compression: str, packed: list[bytes]) -> None:
        """Write a chunk and its index.

        Args:
            pieces: Its records.
            index: Of the records.
            compression: How `packed` holds the records.
            packed: What is written.
        """
        crc = 0
        for piece in pieces:
            crc = zlib.crc32(piece, crc)
        times = [time for records in index.values() for time, _ in records]
        size, held = sum(map(len, pieces)), sum(map(len, packed))
        start, name = self._output.tell(), compression.encode()
        length = _CHUNK.size + len(name) + _SIZE.size + held
        head = _CHUNK.pack(Opcode.CHUNK, length - 9, min(times), max(times), size, crc, len(name))
        self._output.write(head + name + _SIZE.pack(held))
        for piece in packed:
            self._output.write(piece)
        places, written = {}, b""
        for channel, records in index.items():
            places[channel] = start + length + len(written)
            written += _bytes(MessageIndex(channel_id=channel, records=records))
        self._output.write(written)
        self._chunks.append(
            ChunkIndex(
                chunk_start_offset=start, chunk_length=length, compression=compression, compressed_size=held,
                uncompressed_size=size, message_start_time=min(times), message_end_time=max(times),
                message_index_offsets=places, message_index_length=len(written),
            )
        )  # fmt: skip

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=0, channel_count=len(self._channels), channel_message_counts=dict(self._counts),
            chunk_count=len(self._chunks), message_count=self._counts.total(), message_end_time=self._last,
            message_start_time=self._first, metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )  # fmt: skip


def _bytes(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
