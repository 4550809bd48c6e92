"""A bag that was not closed, or is damaged, written anew with an index: what can be read, and no more."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from bathbot_depthcorr.ros.bag_messages import is_bag
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from bathbot_bringup.bag.bombs import LARGEST, refuse_bombs
from bathbot_bringup.bag.reading import NOTES, check_whole, explained
from bathbot_bringup.bag.recording.mcap_bag import McapBag, Source, Stored, remove_bag
from bathbot_bringup.errors import BagError


class Repaired(NamedTuple):
    """What came of it."""

    messages: int
    damaged: int  # parts that could not be read
    trouble: str  # of the last of them; empty when all was read


def repair_bag(bag: Path, out: Path) -> Repaired:
    """Write what can be read of `bag` to a new bag `out`; the old one stays as it is.

    Raises:
        BagError: When `bag` is no MCAP bag, holds nothing that makes a bag, or `out` exists.
    """
    files = sorted(bag.glob("*.mcap")) if bag.is_dir() else [bag]
    if not (bag.is_dir() or is_bag(bag)) or not files or not all(file.is_file() for file in files):
        raise BagError(f"{bag} is neither an .mcap file nor a folder with one; name the bag to repair")
    with explained(bag):
        for file in files:
            refuse_bombs(file)
    repair = _Repair(out)
    try:
        for file in files:
            repair.take(file)
    except OSError as error:
        repair.bag.abandon()
        raise BagError(f"cannot repair {bag}: {error.strerror}; what was read is in {out}") from error
    repair.bag.close()
    messages = sum(repair.bag.counts.values())
    try:
        if repair.trouble and not messages:
            raise BagError(repair.trouble)
        check_whole(out)
    except BagError as error:
        remove_bag(out)
        raise BagError(f"nothing can be read of {bag}: {error.__cause__ or error}") from error
    return Repaired(messages, repair.damaged, repair.trouble)


class _Repair:
    """Copies the records of one file after the other."""

    def __init__(self, out: Path) -> None:
        self.bag = McapBag(out, {"repaired": "yes"})
        self.damaged, self.trouble = 0, ""

    def take(self, file: Path) -> None:
        """Copy what can be read of a file."""
        self._schemas: dict[int, Schema] = {}
        self._sources: dict[int, Source] = {}
        with file.open("rb") as opened:
            records = StreamReader(opened, emit_chunks=True, record_size_limit=LARGEST).records
            while (record := self._next(records)) is not None:
                for part in self._unfolded(record) if isinstance(record, Chunk) else [record]:
                    try:
                        self._copy(part)
                    except OSError:  # of the new bag
                        raise
                    except Exception as error:
                        self._note(error)

    def _next(self, records: Iterator[McapRecord]) -> McapRecord | None:
        try:
            return next(records, None)
        except Exception as error:  # a damaged file leads the parser to errors of any kind
            self._note(error)
            return None

    def _unfolded(self, chunk: Chunk) -> list[McapRecord]:
        try:
            return breakup_chunk(chunk, validate_crc=True)
        except Exception as error:  # as above
            self._note(error)
            return []

    def _note(self, error: Exception) -> None:
        self.damaged += 1
        self.trouble = " ".join(str(error).split()) or type(error).__name__

    def _copy(self, record: McapRecord) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel) and record.schema_id in self._schemas:
            schema = self._schemas[record.schema_id]
            source = Source(record.topic, schema.name)
            if source not in self.bag.counts:
                self.bag.add_defined(source, schema.encoding, schema.data, record.metadata)
            self._sources[record.id] = source
        elif isinstance(record, Message) and record.channel_id in self._sources:
            source = self._sources[record.channel_id]
            self.bag.write(Stored(source, record.log_time, record.data, record.publish_time, record.sequence))
        elif isinstance(record, Metadata) and record.name == NOTES:
            self.bag.note(record.metadata)
