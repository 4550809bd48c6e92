"""An MCAP file that opens as it lies at any moment of its writing, also when its writer is killed.

It always ends with a footer, as readers want it. Before that lies one record of a kind that they skip, as
large as the file may still grow without moving the footer, and sparse on disk. What is appended is first
written inside that record, where nobody looks; then the nine bytes of its head make it part of the file.
A writer can be killed between two pages of memory, so what must be written as one lies within a page.
"""

import errno
import os
import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

_MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")  # kind of a record and its length
_DATA_END, _FOOTER = 0x0F, 0x02
_SPARE = 0x80  # the first kind that the format leaves to applications
_TAIL = _HEAD.pack(_DATA_END, 4) + bytes(4) + _HEAD.pack(_FOOTER, 20) + bytes(20) + _MAGIC
_PAGE = 4096  # [bytes]
_GROWTH = 16 << 20  # [bytes] by which the footer is moved at least


class SteadyFile:
    """What `mcap.writer.Writer` writes to: whole records, one after the other.

    Attributes:
        waiting: What was written and is not in the file yet [bytes].
    """

    def __init__(self, path: Path) -> None:
        """Write to `path`, which appears with the first `flush` and must not exist yet."""
        self._path = path
        self._hidden = path.with_name(f".{path.name}.{os.getpid()}")
        self._file = os.open(self._hidden, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
        self._pending: list[bytes] = []
        self.waiting = 0
        self._end = self._room = 0  # where the spare record begins, and what it holds

    def write(self, data: bytes) -> int:
        """Take records; they are in the file after the next `flush`."""
        if data:  # the writer also hands over nothing
            self._pending.append(bytes(data))
        self.waiting += len(data)
        return len(data)

    def tell(self) -> int:
        """Where the next record will lie."""
        return self._end + self.waiting

    def flush(self) -> None:
        """Make what was written part of the file.

        Raises:
            OSError: The file is as it was before, and what was written still waits.
        """
        if not self._end:
            self._appear(b"".join(self._pending))
        elif self._pending:
            self._append(self._pending, self.waiting)
        self._pending, self.waiting = [], 0

    def sync(self) -> None:
        """Flush, and wait until it is on the disk.

        Raises:
            OSError: As `flush`, or when the file is not where it was any more.
        """
        self.flush()
        os.fdatasync(self._file)
        if self._path.stat().st_ino != os.fstat(self._file).st_ino:
            raise FileNotFoundError(errno.ENOENT, "another file lies there now", str(self._path))

    def close(self) -> None:
        """Drop what may still grow; to be called when the writer has written the true footer."""
        self.sync()
        os.ftruncate(self._file, self._end)
        self.abandon()

    def abandon(self) -> None:
        """Let go of the file as it lies."""
        os.close(self._file)
        self._hidden.unlink(missing_ok=True)

    def _appear(self, data: bytes) -> None:
        try:
            self._put([data, _HEAD.pack(_SPARE, 0), _TAIL], 0)
            os.fsync(self._file)
            os.link(self._hidden, self._path)  # refuses to overwrite
        finally:
            self._hidden.unlink()
        self._end = len(data)

    def _append(self, records: Sequence[bytes], size: int) -> None:
        if (self._end + size) % _PAGE > _PAGE - _HEAD.size:
            records, size = [*records, _HEAD.pack(_SPARE, 0)], size + _HEAD.size
            # or the next head would lie on two pages
        if size > self._room:
            self._grow(max(size, _GROWTH))
        first, *others = map(memoryview, records)
        at = self._put([first[_HEAD.size :], *others], self._end + _HEAD.size)
        self._put([_HEAD.pack(_SPARE, self._room - size)], at)
        self._put([first[: _HEAD.size]], self._end)
        self._end += size
        self._room -= size

    def _grow(self, by: int) -> None:
        room = self._room + by
        room += -(self._end + _HEAD.size + room + len(_TAIL)) % _PAGE
        self._put([_TAIL], self._end + _HEAD.size + room)
        self._put([_HEAD.pack(_SPARE, room)], self._end)
        self._room = room

    def _put(self, pieces: Iterable[bytes | memoryview], at: int) -> int:
        """Write pieces one behind the other, without a copy of pictures; where they end."""
        for piece in pieces:
            view = memoryview(piece)
            while view:
                done = os.pwrite(self._file, view, at)
                view, at = view[done:], at + done
        return at
