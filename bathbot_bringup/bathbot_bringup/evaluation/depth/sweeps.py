"""What a calibration needs, and what harms it: one circumstance after the other is varied, the rest kept."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from bathbot_depthcorr.models.table import DEFAULT_MODEL, PAPERS_MODEL

from bathbot_bringup.evaluation.depth.evaluate_unit import systematic
from bathbot_bringup.evaluation.depth.methods.table import all_methods
from bathbot_bringup.evaluation.depth.simulated_unit import Recording, SimulatedUnit
from bathbot_bringup.evaluation.depth.targets import targets
from bathbot_bringup.sim.camera.d455_unit import Preset

SWEPT = ("basso", PAPERS_MODEL, DEFAULT_MODEL)
# Of each circumstance: how it is told, and its values in the unit in which they are told.
SWEEPS: dict[str, tuple[str, tuple[float, ...]]] = {
    "poses": ("poses", (10, 14, 18, 24, 36)),
    "frames": ("frames a pose", (1, 2, 4, 10)),
    "steepest": ("steepest tilt, deg", (2, 8, 15, 28)),
    "focal_error": ("focal length wrong by, %", (0.0, 0.1, 0.2, 0.3)),
    "square_error": ("squares wrong by, %", (0.0, 0.1, 0.2, 0.3)),
    "outliers": ("wrong matches, %", (0.0, 1.0, 2.0, 5.0)),
    "ripple": ("sub-pixel ripple, px", (0.0, 0.02, 0.04, 0.08)),
}


SWEPT_SIZE = (848, 480)  # [px]: a sweep is many calibrations
SWEPT_UNITS = 3


def sweep_all(preset: Preset, seeds: Sequence[int], tell: Callable[[str], None]) -> dict[str, Any]:
    """Vary every circumstance, on the first few units only and on small pictures."""
    return {name: sweep(name, preset, seeds[:SWEPT_UNITS], SWEPT_SIZE, tell) for name in SWEEPS}


def circumstances(name: str, value: float, preset: Preset) -> tuple[Preset, Recording]:
    """The unit's preset and the recording with one circumstance changed."""
    if name == "ripple":
        return replace(preset, ripple=value), Recording()
    if name in ("poses", "frames"):
        return preset, replace(Recording(), **{name: int(value)})
    if name == "steepest":
        return preset, Recording(steepest=float(np.deg2rad(value)))
    return preset, replace(Recording(), **{name: value / 100.0})


def sweep(
    name: str, preset: Preset, seeds: Sequence[int], size: tuple[int, int], tell: Callable[[str], None]
) -> list[dict[str, Any]]:
    """Systematic error at working distances for each value of one circumstance.

    Returns:
        Rows of `value` and, per method, the mean absolute error over all units [mm].
    """
    label, values = SWEEPS[name]
    rows = []
    for value in values:
        changed, recording = circumstances(name, value, preset)
        found: dict[str, list[float]] = {method: [] for method in SWEPT}
        for seed in seeds:
            tell(f"{label}: {value:g}, unit {seed}")
            unit = SimulatedUnit(seed, changed, *size)
            views, _ = unit.calibration_views(recording)
            fitted = {method: all_methods()[method].fit(views, unit.factory) for method in SWEPT}
            for target in targets(seed):
                if target.kind == "working":
                    for sample in systematic(unit, target, fitted):
                        found[sample.method].append(sample.errors.absolute)
        rows.append({"value": value, **{method: float(np.mean(errors)) for method, errors in found.items()}})
    return rows
