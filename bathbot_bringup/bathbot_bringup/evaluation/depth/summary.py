"""From what units measured to the numbers of the report: means over units, their intervals, the verdicts.

A unit is one draw: intervals come from drawing units anew, not targets.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
from bathbot_depthcorr.models.table import DEFAULT_MODEL
from numpy.typing import ArrayLike

from bathbot_bringup.evaluation.depth.evaluate_unit import Sample, UnitResult
from bathbot_bringup.evaluation.depth.methods.table import UNCORRECTED
from bathbot_bringup.evaluation.depth.targets import DISTANCES, RADII

Item = TypeVar("Item")

DRAWS = 10_000  # of the bootstrap over units
LEVEL = 0.95


class Interval(NamedTuple):
    """A mean and the bounds of its 95 % interval; bounds are NaN for fewer than two units."""

    mean: float
    low: float
    high: float


def interval(by_unit: ArrayLike, seed: int = 0) -> Interval:
    """Percentile interval of the mean over units.

    Args:
        by_unit: One mean per unit, shape (N,).
        seed: Of the draws.
    """
    values = np.asarray(by_unit, dtype=float)
    if len(values) < 2:
        return Interval(float(values.mean()), float("nan"), float("nan"))
    draws = np.random.default_rng(seed).integers(0, len(values), (DRAWS, len(values)))
    tail = 0.5 * (1.0 - LEVEL)
    low, high = np.quantile(values[draws].mean(axis=1), (tail, 1.0 - tail))
    return Interval(float(values.mean()), float(low), float(high))


def verdict(difference: Interval) -> str:
    """Read the interval of another method's error minus ours: better, level or worse (ours)."""
    if not np.isfinite(difference.low):
        return "one unit"
    if difference.low > 0.0:
        return "better"
    return "worse" if difference.high < 0.0 else "level"


def by_unit(
    results: Sequence[UnitResult],
    items: Callable[[UnitResult], Iterable[Item]],
    value: Callable[[Item], float],
) -> np.ndarray:
    """Mean of a value over the items of each unit, shape (units,)."""
    return np.array([np.mean([value(item) for item in items(result)]) for result in results])


def systematic_by_unit(
    results: Sequence[UnitResult], method: str, wanted: Callable[[Sample], bool], key: str = "absolute"
) -> np.ndarray:
    """Mean error without noise [mm] of one method over the targets that are wanted, shape (units,)."""
    return by_unit(
        results,
        lambda result: [sample for sample in result.samples if sample.method == method and wanted(sample)],
        lambda sample: getattr(sample.errors, key),
    )


def at_distance(distance: float) -> Callable[[Sample], bool]:
    """Walls at one distance [m]."""
    return lambda sample: sample.target.kind == "wall" and sample.target.distance == distance


def working(sample: Sample) -> bool:
    """Walls at the working distances."""
    return sample.target.kind == "working"


def summarise(results: Sequence[UnitResult], methods: Sequence[str]) -> dict[str, Any]:
    """All numbers but Table 2, in mm where not said otherwise."""
    walls = {
        method: {z: interval(systematic_by_unit(results, method, at_distance(z))) for z in DISTANCES}
        for method in methods
    }
    signed = {
        method: {
            z: float(systematic_by_unit(results, method, at_distance(z), "signed").mean()) for z in DISTANCES
        }
        for method in methods
    }
    near = {method: interval(systematic_by_unit(results, method, working)) for method in methods}
    frames = {method: _frames(results, method) for method in methods}
    return {
        "raw_mm": near[UNCORRECTED].mean,
        "systematic_mm": {
            method: {z: found.mean for z, found in row.items()} for method, row in walls.items()
        },
        "one_frame_mm": frames[DEFAULT_MODEL]["absolute"],
        "rmse_mm": frames[DEFAULT_MODEL]["rmse"],
        "working_mm": {method: found.mean for method, found in near.items()},
        "interval_mm": {
            method: {z: [found.low, found.high] for z, found in row.items()} for method, row in walls.items()
        },
        "signed_mm": signed,
        "against": {
            method: {z: _compare(results, method, z) for z in DISTANCES}
            for method in methods
            if method != DEFAULT_MODEL
        },
        "cylinder_mm": {
            method: {radius: _cylinder(results, method, radius) for radius in RADII} for method in methods
        },
        "frames": frames,
        "noise_rms_mm": {method: _noise(results, method) for method in methods},
        "fit": {method: _fit(results, method) for method in methods},
        "focal_change": [result.focal_change for result in results],
    }


def _compare(results: Sequence[UnitResult], method: str, distance: float) -> dict[str, Any]:
    """The other method's error minus ours at a distance, unit by unit."""
    theirs, ours = (
        systematic_by_unit(results, name, at_distance(distance)) for name in (method, DEFAULT_MODEL)
    )
    difference: Interval = interval(theirs - ours)
    return {"difference_mm": list(difference), "ours_is": verdict(difference)}


def _cylinder(results: Sequence[UnitResult], method: str, radius: float) -> float:
    return float(
        systematic_by_unit(
            results, method, lambda s: s.target.kind == "cylinder" and s.target.radius == radius
        ).mean()
    )


def _frames(results: Sequence[UnitResult], method: str) -> dict[str, float]:
    """One frame of a wall at 0.6 to 0.9 m, noise included."""
    rows = [sample for result in results for sample in result.frames if sample.method == method]
    mean = lambda value: float(np.mean([value(row) for row in rows]))  # noqa: E731
    return {
        "absolute": mean(lambda row: row.errors.absolute), "signed": mean(lambda row: row.errors.signed),
        "percentile_95": mean(lambda row: row.errors.percentile_95),
        "inner": mean(lambda row: row.errors.inner), "fill": mean(lambda row: row.errors.fill),
        "rmse": mean(lambda row: row.flatness.rmse), "subpixel_px": mean(lambda row: row.flatness.subpixel),
        "point": mean(lambda row: row.flatness.point), "normal_deg": mean(lambda row: row.flatness.normal),
    }  # fmt: skip


def _noise(results: Sequence[UnitResult], method: str) -> dict[str, float]:
    rows = [noise for result in results for noise in result.noise if noise.method == method]
    return {
        part: float(np.mean([getattr(row, part) for row in rows]))
        for part in ("systematic", "frozen", "temporal")
    }


def _fit(results: Sequence[UnitResult], method: str) -> dict[str, float]:
    rows = [fit for result in results for fit in result.fits if fit.method == method]
    names = {"seconds": "seconds", "turn": "extrinsics_deg", "move": "extrinsics_mm"}
    return {told: float(np.median([getattr(row, name) for row in rows])) for name, told in names.items()}
