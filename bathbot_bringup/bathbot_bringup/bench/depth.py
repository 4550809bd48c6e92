"""`bathbot bench depth`: is the live correction fast enough for the camera, and at what cost?"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from bathbot_depthcorr.models.table import DEFAULT_MODEL
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from bathbot_bringup.bench.apply import ApplyTime, time_apply
from bathbot_bringup.bench.machine import machine, machine_words
from bathbot_bringup.bench.scene import bench_camera, bench_corrections, bench_frames
from bathbot_bringup.bench.stream import StreamResult, watch_stream
from bathbot_bringup.errors import InputError
from bathbot_bringup.files import log_folder, write_json


@dataclass(frozen=True, slots=True)
class DepthBench:
    """What to measure.

    Attributes:
        size: Width and height of the frames [px].
        rate: Frames per second [Hz].
        seconds: How long the node is watched [s].
    """

    size: tuple[int, int]
    rate: float
    seconds: float

    def __post_init__(self) -> None:
        """Refuse what cannot be measured."""
        if min(self.size) < 32:
            raise InputError(f"size must be 32x32 or more, got {self.size[0]}x{self.size[1]}")
        if not 1.0 <= self.rate <= 120.0:
            raise InputError(f"rate must lie in 1..120 Hz, got {self.rate}; a D455 gives up to 90")
        if not 1.0 <= self.seconds <= 3600.0:
            raise InputError(f"seconds must lie in 1..3600, got {self.seconds}")


def bench_depth(bench: DepthBench, json_file: Path | None) -> None:
    """Time the kernel, then the node under a stream; print a table and write the numbers.

    Args:
        bench: What to measure.
        json_file: Where to write the numbers; None writes none.
    """
    console, here = Console(highlight=False), machine()
    size, rate, seconds = bench.size, bench.rate, bench.seconds
    camera = bench_camera(*size)
    frame = bench_frames(camera, 1)[0]
    applied = {name: time_apply(one, frame) for name, one in bench_corrections(camera).items()}
    with Progress(console=console, transient=True) as bar, log_folder("bench") as folder:
        task = bar.add_task(f"depth_corrector at {rate:g} Hz", total=1.0)
        stream = watch_stream(size, rate, seconds, folder, lambda share: bar.update(task, completed=share))
    numbers = _numbers(applied, stream) | {
        "size": f"{size[0]}x{size[1]}", "rate_hz": rate, "seconds": seconds, "machine": here,
    }  # fmt: skip
    _print(console, numbers)
    if json_file:
        write_json(json_file, numbers)


def _numbers(applied: dict[str, ApplyTime], stream: StreamResult) -> dict[str, Any]:
    latency = np.percentile(stream.latencies_ms, (50, 99)) if stream.got else (float("nan"),) * 2
    models = {name: times._asdict() for name, times in applied.items()}
    return models[DEFAULT_MODEL] | {
        "model": DEFAULT_MODEL, "models": models,
        "node_dropped": stream.dropped, "node_counted": stream.counted, "node_cpu": stream.cpu,
        "frames_sent": stream.sent, "frames_got": stream.got,
        "latency_ms_p50": latency[0], "latency_ms_p99": latency[1],
    }  # fmt: skip


def _print(console: Console, numbers: dict[str, Any]) -> None:
    stream = f"{numbers['size']} at {numbers['rate_hz']:g} Hz for {numbers['seconds']:g} s"
    table = Table(
        "what", "measured", "at most", title=f"depth correction, {stream}",
        caption=machine_words(numbers["machine"]),
    )  # fmt: skip
    for name, times in numbers["models"].items():
        applied = f"{times['apply_over_copy']:.2f}  ({times['apply_ms']:.2f} / {times['copy_ms']:.2f} ms)"
        bound = "3" if name == numbers["model"] else ""
        table.add_row(f"{name} over a copy of the frame", applied, bound)
    table.add_row("frames dropped by the node", f"{numbers['node_dropped']} of {numbers['frames_sent']}", "0")
    table.add_row("the node's share of one core", f"{numbers['node_cpu']:.1%}", "40 %")
    latency = f"{numbers['latency_ms_p50']:.1f} / {numbers['latency_ms_p99']:.1f} ms"
    table.add_row("stamp to arrival, median / 99 %", latency, "")
    console.print(table)
