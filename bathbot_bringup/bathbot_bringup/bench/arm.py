"""`bathbot bench arm`: the inverse kinematics beside others', and the joint stream beside the whole graph."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from bathbot_bringup.bench.arm_stream import watch_arm
from bathbot_bringup.bench.ik import bench_ik
from bathbot_bringup.bench.machine import machine, machine_words
from bathbot_bringup.errors import InputError
from bathbot_bringup.files import log_folder, write_json

_LONGEST = 1100.0  # [s] the emulator's trace holds twenty minutes of frames


@dataclass(frozen=True, slots=True)
class ArmBench:
    """What to measure."""

    seconds: float = 600.0  # how long the stream is watched; 0: not at all

    def __post_init__(self) -> None:
        """Refuse what cannot be measured."""
        if not (self.seconds == 0.0 or 20.0 <= self.seconds <= _LONGEST):
            raise InputError(f"seconds must be 0 or lie in 20..{_LONGEST:g}, got {self.seconds}")


def bench_arm(bench: ArmBench, json_file: Path | None) -> None:
    """Time the kinematics, then the stream; print a table and write the numbers.

    Args:
        bench: What to measure.
        json_file: Where to write the numbers; None writes none.
    """
    if json_file:
        json_file.parent.mkdir(parents=True, exist_ok=True)
    console, here = Console(highlight=False), machine()
    numbers: dict[str, Any] = {"machine": here, "seconds": bench.seconds, **bench_ik()._asdict()}
    if bench.seconds:
        with Progress(console=console, transient=True) as bar, log_folder("bench") as folder:
            task = bar.add_task("joint stream beside the whole graph", total=1.0)
            stream = watch_arm(bench.seconds, folder, lambda share: bar.update(task, completed=share))
        numbers |= stream._asdict()
    console.print(arm_table(numbers))
    if json_file:
        write_json(json_file, numbers)


def arm_table(numbers: Mapping[str, Any]) -> Table:
    """The results beside what they must be."""
    table = Table(
        "what", "measured", "must be", title="the arm on this machine",
        caption=machine_words(numbers["machine"]),
    )  # fmt: skip
    table.add_row("inverse kinematics, us a pose of a path", f"{numbers['ik_us_per_pose']:.2f}", "<= 5")
    for key, name in (("eaik", "EAIK"), ("pin", "Pinocchio")):
        row = f"{numbers[f'ik_vs_{key}']:.1f} times ({numbers[f'{key}_us_per_pose']:.1f} us)"
        table.add_row(f"{name}'s time over ours", row, "> 1")
    if "frames" in numbers:
        missed = f"{numbers['stream_missed']} of {numbers['frames']}"
        table.add_row("periods of the stream above 20 ms", missed, "0")
        table.add_row("the longest", f"{numbers['longest_period_ms']:.1f} ms", "20 ms")
        table.add_row("period, 99 % of |deviation|", f"{numbers['stream_period_p99_dev_ms']:.2f} ms", "")
        table.add_row("frames refused by either side", str(numbers["protocol_errors"]), "0")
        table.add_row("state push", f"{numbers['push_hz']:.1f} Hz", "198..202")
    return table
