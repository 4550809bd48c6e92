"""The demo over many seeds, one after the other, each in a program of its own."""

import json
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.files import write_json
from bathbot_bringup.graph.processes import Patience, ProcessGroup, node_environment
from bathbot_bringup.report.summary_table import print_spread, spread

_PATIENCE: Patience = ((signal.SIGINT, 40.0), (signal.SIGKILL, 2.0))  # a demo ends its own processes first

_LONGEST = 900.0  # [s] no demo takes longer, whatever its duration

SettingsOf = Callable[[int, Path], DemoSettings]


def demo_arguments(settings: DemoSettings) -> list[str]:
    """Write settings as the arguments of `bathbot demo`."""
    return [
        "demo", "--region", settings.region, "--seed", str(settings.seed), "--scenario", settings.scenario,
        "--out", str(settings.out), "--duration", str(settings.duration), "--rate", str(settings.rate),
        "--preset", settings.preset, "--calibration", str(settings.calibration.absolute()),
    ]  # fmt: skip


def run_seed(settings: DemoSettings, logs: Path) -> dict[str, Any]:
    """Run one demo; a run that left no summary gives one that says why.

    Args:
        settings: Of the run.
        logs: Folder for what it prints.
    """
    command = [sys.executable, "-m", "bathbot_bringup.command.cli", *demo_arguments(settings)]
    with ProcessGroup(logs, node_environment(logs), _PATIENCE) as group:
        child = group.start(f"seed-{settings.seed}", command)
        try:
            child.process.wait(_LONGEST)
        except subprocess.TimeoutExpired:
            return _undone(settings, f"it did not end within {_LONGEST:.0f} s")
        said = child.last_line()
    try:
        return json.loads((settings.out / "summary.json").read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError):
        return _undone(settings, said or "it left no summary")


def _undone(settings: DemoSettings, failure: str) -> dict[str, Any]:
    return {"done": False, "seed": settings.seed, "region": settings.region, "failure": failure}


def evaluate_demo(
    settings_of: SettingsOf, seeds: Sequence[int], json_file: Path | None, out: Path | None
) -> int:
    """Run all seeds, print a table, write the numbers.

    Args:
        settings_of: Gives the settings of a seed and its folder.
        seeds: Which.
        json_file: Where to write summaries and their spread; None writes nothing.
        out: Folder that keeps the results of each seed; None keeps none.

    Returns:
        0 if every job was done, else 1.
    """
    settings_of(seeds[0], Path("unused"))  # refuses bad options before anything starts
    console = Console(highlight=False)
    summaries = []
    with tempfile.TemporaryDirectory() as temporary:
        for seed in seeds:
            folder = (out or Path(temporary)) / f"seed-{seed}"
            summary = run_seed(settings_of(seed, folder), Path(temporary) / "logs")
            summaries.append(summary)
            console.print(_line(summary), markup=False, soft_wrap=True)
    print_spread(console, summaries)
    if json_file:
        write_json(json_file, {"spread": spread(summaries), "runs": summaries})
    return 0 if all(summary["done"] for summary in summaries) else 1


def _line(summary: dict[str, Any]) -> str:
    if not summary["done"]:
        return f"seed {summary['seed']}: NOT DONE: {summary['failure']}"
    return (
        f"seed {summary['seed']}: done in {summary['duration_s']:.0f} s, "
        f"located to {summary['localization_error_mm']:.2f} mm, "
        f"{100 * summary['contact_fraction']:.0f} % in contact, at most {summary['force_peak_n']:.1f} N"
    )
