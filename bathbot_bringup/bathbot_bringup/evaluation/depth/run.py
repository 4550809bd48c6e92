"""Depth corrections against simulated cameras whose truth is known: `bathbot evaluate depth`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from bathbot_depthcorr.models.table import DEFAULT_MODEL, PAPERS_MODEL
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from bathbot_bringup.errors import InputError
from bathbot_bringup.evaluation.depth.conditions import condition_errors
from bathbot_bringup.evaluation.depth.evaluate_unit import evaluate_unit, signed_map
from bathbot_bringup.evaluation.depth.figures import MAP_DISTANCES, save_figures
from bathbot_bringup.evaluation.depth.measures import Fitted
from bathbot_bringup.evaluation.depth.methods.table import UNCORRECTED, all_methods
from bathbot_bringup.evaluation.depth.simulated_unit import Recording, SimulatedUnit
from bathbot_bringup.evaluation.depth.summary import summarise
from bathbot_bringup.evaluation.depth.sweeps import sweep_all
from bathbot_bringup.evaluation.depth.table_2 import replay, table
from bathbot_bringup.evaluation.depth.tables import print_summary
from bathbot_bringup.files import write_json
from bathbot_bringup.sim.camera.d455_unit import find_preset, make_unit

LEAST_POSES = 10
_REPLAYED = (UNCORRECTED, PAPERS_MODEL, DEFAULT_MODEL)


@dataclass(frozen=True, slots=True)
class DepthEvaluation:
    """What to evaluate on."""

    seeds: Sequence[int] = (0, 1, 2, 3, 4)
    preset: str = "paper"
    size: tuple[int, int] = (1280, 720)
    poses: int = 24
    frames: int = 4
    sweeps: bool = False
    figures: Path | None = None
    json_file: Path | None = field(default=None)

    def __post_init__(self) -> None:
        """Refuse what cannot be evaluated."""
        make_unit(0, find_preset(self.preset), *self.size)
        if self.poses < LEAST_POSES:
            raise InputError(f"a calibration needs at least {LEAST_POSES} poses, got {self.poses}")


def evaluate_depth(settings: DepthEvaluation, console: Console | None = None) -> dict[str, Any]:
    """Run all units, print the tables, write numbers and pictures.

    Returns:
        The numbers, as they stand in the JSON file.
    """
    console = console or Console(highlight=False)
    for folder in (settings.figures, settings.json_file.parent if settings.json_file else None):
        if folder is not None:  # a place that cannot be written is known now, not after minutes of work
            folder.mkdir(parents=True, exist_ok=True)
    results, replays, conditions, maps = [], [], [], {}
    bar = Progress(
        TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), console=console, transient=True
    )
    with bar as progress:
        task = progress.add_task("", total=len(settings.seeds))
        for seed in settings.seeds:
            tell = _teller(progress, task, seed)
            unit = SimulatedUnit(seed, find_preset(settings.preset), *settings.size)
            result, fitted = evaluate_unit(
                unit, Recording(settings.poses, settings.frames), list(all_methods()), tell
            )
            results.append(result)
            tell("Table 2")
            replays.append(replay(unit, {name: fitted[name] for name in _REPLAYED}))
            tell("temperature, water, steam")
            conditions.append(condition_errors(unit, fitted[DEFAULT_MODEL]))
            maps = maps or _signed_maps(unit, fitted)
            progress.advance(task)
        tell = _teller(progress, task, settings.seeds[0])
        swept = sweep_all(find_preset(settings.preset), settings.seeds, tell) if settings.sweeps else {}
    summary = {
        **summarise(results, list(all_methods())), "table2": table(replays, DEFAULT_MODEL),
        "conditions_mm": {name: float(np.mean([row[name] for row in conditions])) for name in conditions[0]},
        "preset": settings.preset, "units": len(results), "seeds": list(settings.seeds),
        "size": list(settings.size), "poses": settings.poses, "frames_per_pose": settings.frames,
        "model": DEFAULT_MODEL, "sweeps_mm": swept, "simulated": True,
    }  # fmt: skip
    print_summary(summary, console)
    if settings.json_file:
        write_json(settings.json_file, summary)
    if settings.figures:
        for path in save_figures(settings.figures, summary, maps):
            console.print(f"wrote {path}", markup=False, soft_wrap=True)
    return summary


def _teller(progress: Progress, task: Any, seed: int) -> Callable[[str], None]:
    return lambda step: progress.update(task, description=f"unit {seed}: {step}")


def _signed_maps(unit: SimulatedUnit, fitted: dict[str, Fitted]) -> dict[str, dict[float, np.ndarray]]:
    return {
        name: {distance: signed_map(unit, distance, correction) for distance in MAP_DISTANCES}
        for name, correction in fitted.items()
    }
