"""Contact targets against the simulated truth over many seeds; the arm stays at home."""

import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from bathbot_bringup.bathing.finder_node import RegionFinder
from bathbot_bringup.bathing.nodes import SEEING, demo_nodes
from bathbot_bringup.bathing.settings import DemoSettings
from bathbot_bringup.errors import BringupError
from bathbot_bringup.evaluation.demo import SettingsOf
from bathbot_bringup.files import write_json
from bathbot_bringup.graph.isolation import free_ports
from bathbot_bringup.graph.running import running
from bathbot_bringup.report.truth import Truth, seen_target

_LOOK = 60.0  # [s]


def locate(settings: DemoSettings, count: int, folder: Path) -> np.ndarray:
    """Gather contact targets of one seed.

    Args:
        settings: Of the scene.
        count: How many targets.
        folder: For the logs.

    Returns:
        Found minus true positions [m] in the base frame, shape (count, 3).

    Raises:
        BringupError: When the graph fails or the region is not found often enough in time.
    """
    epoch = time.time()
    nodes = demo_nodes(settings, epoch, free_ports(), folder / "unused.mcap")
    seeing = {name: parameters for name, parameters in nodes.items() if name in SEEING}
    with running(seeing, folder, "bathbot_evaluate") as graph:
        finder = RegionFinder(graph.client, settings.region)
        finder.select()
        sightings = finder.gather(count, _LOOK)
    truth = Truth(settings, epoch)
    return np.array([truth.target_error(seen_target(sighting)) for sighting in sightings])


def evaluate_localization(
    settings_of: SettingsOf, seeds: Sequence[int], count: int, json_file: Path | None
) -> int:
    """Run all seeds, print a table, write the numbers.

    Returns:
        0 if the region was found for every seed, else 1.
    """
    settings_of(seeds[0], Path("unused"))  # refuses bad options before anything starts
    console = Console(highlight=False)
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as temporary:
        for seed in seeds:
            try:
                errors = locate(settings_of(seed, Path(temporary)), count, Path(temporary) / f"seed-{seed}")
            except BringupError as error:
                rows.append({"seed": seed, "failure": str(error)})
                console.print(f"seed {seed}: {error}", markup=False, soft_wrap=True)
                continue
            distance = 1000.0 * np.linalg.norm(errors, axis=1)
            rows.append({
                "seed": seed, "count": len(distance), "mean_mm": distance.mean(), "std_mm": distance.std(),
                "max_mm": distance.max(), "bias_mm": list(1000.0 * errors.mean(axis=0)),
                "errors_mm": list(distance),
            })  # fmt: skip
            console.print(
                f"seed {seed}: mean {distance.mean():.2f} mm, max {distance.max():.2f} mm", markup=False
            )
    _print_rows(console, rows)
    found = [row for row in rows if "mean_mm" in row]
    if json_file:
        every = np.array([value for row in found for value in row["errors_mm"]])
        total = {"mean_mm": every.mean(), "std_mm": every.std(), "max_mm": every.max()} if len(every) else {}
        write_json(json_file, {"simulated": True, "all": total, "seeds": rows})
    return 0 if len(found) == len(rows) else 1


def _print_rows(console: Console, rows: Sequence[dict[str, Any]]) -> None:
    table = Table(
        "seed", "targets", "mean", "std", "max", "bias x, y, z", title="localisation error in mm (simulated)"
    )
    for row in rows:
        if "mean_mm" in row:
            bias = ", ".join(f"{value:+.2f}" for value in row["bias_mm"])
            numbers = (f"{row[key]:.2f}" for key in ("mean_mm", "std_mm", "max_mm"))
            table.add_row(str(row["seed"]), str(row["count"]), *numbers, bias)
        else:
            table.add_row(str(row["seed"]), "-", "-", "-", "-", "-")
    console.print(table)
