"""The real depth corrector under a real stream: what it drops, what it costs, how late it is."""

import os
import sys
import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bathbot_bringup.bench.scene import bench_camera, bench_correction
from bathbot_bringup.bench.source_node import BenchListener
from bathbot_bringup.errors import BringupError
from bathbot_bringup.graph.node_table import find_node, node_command
from bathbot_bringup.graph.running import started

_START, _LINGER = 60.0, 1.0  # [s] until the first frame comes out, after the last that counts
_SOURCE = "bench_source"


class StreamError(BringupError):
    """The corrector did not correct the bench's stream."""


class StreamResult(NamedTuple):
    """How the node kept up.

    Attributes:
        sent: Frames sent while it was watched.
        got: Those of them that came out corrected.
        counted: Frames that the node itself says it dropped, since its start; the rest was lost on the way.
        cpu: Processor time of the node's process over wall time, 1 = one core.
        latencies_ms: From a frame's stamp to its arrival, shape (got,) [ms].
    """

    sent: int
    got: int
    counted: int
    cpu: float
    latencies_ms: np.ndarray

    @property
    def dropped(self) -> int:
        """Frames that never came out."""
        return self.sent - self.got


def cpu_seconds(pid: int) -> float:
    """Processor time a process has used so far, its threads and the kernel's work for it included [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def watch_stream(
    size: tuple[int, int], rate: float, seconds: float, folder: Path, progress: Callable[[float], object]
) -> StreamResult:
    """Start the node and a camera as processes, let them run, count what comes out.

    Args:
        size: Width and height of the frames [px].
        rate: Frames per second [Hz].
        seconds: How long to watch, from the first corrected frame on [s].
        folder: For the calibration and the logs.
        progress: Called all the while with the share that is done, 0..1.

    Raises:
        ProcessError: When a process dies or does not start.
        StreamError: When no frame comes out, or the node says that something is wrong.
    """
    calibration = folder / "calibration.npz"
    bench_correction(bench_camera(*size)).save(calibration)
    entry = find_node("depth_corrector")
    with started({}, folder, "bathbot_bench") as graph:
        client, listener = graph.client, BenchListener(graph.client.node)
        # not as gently as beside the arm: what else runs on the machine is not to be measured
        corrector = graph.group.start(entry.name, node_command(entry, {"calibration": calibration}))
        graph.wait_until_active()
        source = [sys.executable, "-m", "bathbot_bringup.bench.source_node"]
        graph.group.start(_SOURCE, [*source, *map(str, size), str(rate)])
        if not client.spin_until(lambda: len(listener.arrivals) > 1, _START):
            raise StreamError(f"no corrected frame within {_START:.0f} s: {listener.trouble}")
        begin, cpu = time.time(), cpu_seconds(corrector.process.pid)
        client.spin_until(lambda: progress((time.time() - begin) / seconds), seconds)
        cpu = (cpu_seconds(corrector.process.pid) - cpu) / (time.time() - begin)
        client.wait(_LINGER)
        if listener.trouble:
            raise StreamError(f"depth_corrector reports: {listener.trouble}")
    sent = round(rate * seconds)
    stamps = arrived(listener.arrivals, begin, sent, rate)
    latencies = np.array([1e3 * (listener.arrivals[stamp] - stamp) for stamp in stamps])
    return StreamResult(sent, len(stamps), listener.counted, cpu, latencies)


def arrived(arrivals: Collection[float], begin: float, sent: int, rate: float) -> list[float]:
    """Find which of the `sent` frames from the time `begin` [s] on have come out.

    Args:
        arrivals: Stamps of all frames that came out [s]; they lie 1 / rate apart where none is missing.
        begin: Time of the first frame that counts [s].
        sent: How many count.
        rate: Frames per second [Hz].
    """
    anchor = min(arrivals)
    first = int(np.ceil((begin - anchor) * rate))
    numbers = {round((stamp - anchor) * rate): stamp for stamp in arrivals}
    return [numbers[number] for number in range(first, first + sent) if number in numbers]
