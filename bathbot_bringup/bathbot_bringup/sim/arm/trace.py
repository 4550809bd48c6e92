"""The black box of the emulated arm: what really happened, step by step, for whoever judges a run.

Stamps are of time.monotonic(), the same clock in all processes of one machine.
"""

import io
import zipfile
import zlib
from collections import deque
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.bounded_files import read_npz
from numpy.typing import ArrayLike, NDArray

from bathbot_bringup.errors import InputError
from bathbot_bringup.files import write_file
from bathbot_bringup.sim.faults.fault_schedule import FaultEvent

Array = NDArray[np.float64]
KEPT = 120_000  # steps: the newest ten minutes
_MOST_EVENTS = 10_000
_IN_DANGER = 200  # rows that may be overwritten while they are being copied
_COLUMNS = {
    "stamp": 1, "joints": 6, "joint_speeds": 6, "head": 3, "approach": 3, "force": 3, "compression": 1,
    "indentation": 1, "pushed_force": 1,
}  # fmt: skip


class TraceData(NamedTuple):
    """What a trace holds, oldest first: N steps, M frames of the joint stream, K beginnings and ends."""

    stamp: Array  # [s], shape (N,)
    joints: Array  # [rad], shape (N, 6)
    joint_speeds: Array  # [rad/s], shape (N, 6)
    head: Array  # tip of the unbent bristles in the base frame [m], shape (N, 3)
    approach: Array  # the head's z axis in the base frame, shape (N, 3)
    force: Array  # of the contact, on the head, in the base frame [N], shape (N, 3)
    compression: Array  # of the bristles [m], negative: a gap, shape (N,)
    indentation: Array  # of the skin [m], shape (N,)
    pushed_force: Array  # resultant of the zeroed force as pushed [N], NaN when not pushed, shape (N,)
    frame_stamp: Array  # [s], shape (M,)
    frame_joints: Array  # [rad], shape (M, 6)
    event_stamp: Array  # [s], shape (K,)
    event_kind: NDArray[np.str_]  # of a fault, shape (K,)
    event_phase: NDArray[np.str_]  # "begin" or "end", shape (K,)


class _Ring:
    """The newest rows of a table; one thread appends, any thread copies."""

    def __init__(self, rows: int, columns: int) -> None:
        self._table = np.zeros((rows, columns))  # the system gives memory only to rows that are written
        self._count = 0
        self._first = 0

    def append(self, row: ArrayLike) -> None:
        self._table[self._count % len(self._table)] = row
        self._count += 1

    def clear(self) -> None:
        self._first = self._count

    def copy(self) -> Array:
        end, size = self._count, len(self._table)
        oldest = end - size + _IN_DANGER if end > size - _IN_DANGER else 0
        return self._table[np.arange(max(self._first, oldest), end) % size]


class Trace:
    """Records the emulated arm; memory is bounded."""

    def __init__(self, kept: int = KEPT) -> None:
        """Keep the newest `kept` steps, and as many frames of the stream."""
        self._steps = _Ring(kept + _IN_DANGER, sum(_COLUMNS.values()))
        self._frames = _Ring(kept + _IN_DANGER, 7)
        self._events: deque[FaultEvent] = deque(maxlen=_MOST_EVENTS)

    def step(self, row: list[float]) -> None:
        """Take one step: 25 numbers in the order of `TraceData`, stamp to pushed_force."""
        self._steps.append(row)

    def frame(self, stamp: float, joints: ArrayLike) -> None:
        """Take a frame of the joint stream, angles [rad], shape (6,)."""
        self._frames.append([stamp, *np.asarray(joints, dtype=float)])

    def events(self, events: list[FaultEvent]) -> None:
        """Take beginnings and ends of faults."""
        self._events.extend(events)

    def clear(self) -> None:
        """Forget what was recorded so far."""
        self._steps.clear()
        self._frames.clear()
        self._events.clear()

    def data(self) -> TraceData:
        """Copy what is recorded; from any thread."""
        steps, frames, events = self._steps.copy(), self._frames.copy(), list(self._events)
        edges = np.cumsum([0, *_COLUMNS.values()])
        parts = [steps[:, a:b] if b - a > 1 else steps[:, a] for a, b in pairwise(edges)]
        return TraceData(
            *parts,
            frame_stamp=frames[:, 0],
            frame_joints=frames[:, 1:],
            event_stamp=np.array([event.stamp for event in events], dtype=float),
            event_kind=np.array([event.kind for event in events], dtype=str),
            event_phase=np.array([event.phase for event in events], dtype=str),
        )

    def write(self, path: str | Path) -> None:
        """Write an .npz file; whoever waits for it never sees half of one.

        Raises:
            InputError: When it cannot be written, or is not to be an .npz: who asks over a topic shall not
                overwrite anything else.
        """
        if Path(path).suffix != ".npz":
            raise InputError(f"a trace is written to an .npz file, got {path}; choose another name")
        content = io.BytesIO()
        np.savez(content, **self.data()._asdict())
        try:
            write_file(Path(path), content.getvalue())
        except OSError as error:
            raise InputError(f"cannot write trace {path}: {error.strerror}; choose another path") from error


def load_trace(path: str | Path) -> TraceData:
    """Read what `Trace.write` wrote.

    Raises:
        InputError: When it is no trace.
    """
    try:
        arrays = read_npz(path)
        return TraceData(**{name: arrays[name] for name in TraceData._fields})
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        raise InputError(f"{path} is no trace of the emulated arm: {' '.join(str(error).split())}") from error
