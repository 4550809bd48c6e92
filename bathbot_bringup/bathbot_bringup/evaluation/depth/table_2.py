"""The paper's Table 2 again: its eight positions, seen by simulated units, beside the published figures.

A position is a point in the colour camera's frame with a small wall facing the camera; the error is the
median over a circle about it. The published raw column cannot be a function of position alone: rows 4 and 5,
and 6 and 8, are one place each with raw errors up to 5.4 mm apart. So each position is seen many times.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse, transform_points
from bathbot_depthcorr.models.table import PAPERS_MODEL

from bathbot_bringup.evaluation.depth.measures import CIRCLE, Fitted
from bathbot_bringup.evaluation.depth.methods.table import UNCORRECTED
from bathbot_bringup.evaluation.depth.simulated_unit import SimulatedUnit
from bathbot_bringup.evaluation.depth.targets import wall

DRAWS = 20  # per position and unit


class PublishedRow(NamedTuple):
    """A row of Table 2: theoretical position [mm], Z error and depth error before correction [mm]."""

    number: int
    position: tuple[float, float, float]
    z_error: float
    raw_error: float


PUBLISHED = (
    PublishedRow(1, (251.04, 375.06, 763.69), 1.46, 21.02),
    PublishedRow(2, (292.02, 272.92, 833.79), 1.34, 19.35),
    PublishedRow(3, (242.42, 162.88, 725.62), 0.07, 14.87),
    PublishedRow(4, (246.15, 344.01, 631.70), 0.70, 14.45),
    PublishedRow(5, (246.56, 344.50, 631.16), 1.50, 16.34),
    PublishedRow(6, (328.02, 148.08, 855.10), 1.60, 24.34),
    PublishedRow(7, (253.30, 373.52, 762.91), 1.10, 17.28),
    PublishedRow(8, (327.11, 147.31, 854.44), 1.12, 18.98),
)
PUBLISHED_RAW = float(np.mean([row.raw_error for row in PUBLISHED]))  # 18.329 mm
PUBLISHED_CORRECTED = float(np.mean([row.z_error for row in PUBLISHED]))  # 1.111 mm


def replay(unit: SimulatedUnit, fitted: dict[str, Fitted], draws: int = DRAWS) -> dict[str, np.ndarray]:
    """See each position some times, the noise of texture and sensor drawn anew.

    Returns:
        Per method: signed errors [mm], shape (8, draws); NaN where the picture has no depth.
    """
    found = {name: np.full((len(PUBLISHED), draws), np.nan) for name in fitted}
    for index, row in enumerate(PUBLISHED):
        point = np.array(row.position) * 1e-3
        surface = wall(point[2])
        truth = unit.truth(surface)
        camera = unit.factory.depth_camera
        u, v = camera.project(transform_points(inverse(unit.T_colour_depth), point))
        radius = CIRCLE * camera.width / 848
        rows, columns = np.mgrid[: camera.height, : camera.width]
        circle = (columns - u) ** 2 + (rows - v) ** 2 <= radius**2
        expected = {
            name: unit.expected(surface, correction.T_colour_depth)[circle]
            for name, correction in fitted.items()
        }
        for draw in range(draws):
            frame = unit.frame(truth, draw, 200 + index * draws + draw)
            for name, correction in fitted.items():
                error = correction.apply(frame)[circle] - expected[name]
                if np.isfinite(error).any():
                    found[name][index, draw] = 1e3 * float(np.nanmedian(error))
    return found


def table(by_unit: Sequence[dict[str, np.ndarray]], method: str) -> list[dict[str, object]]:
    """Rows of the table: published figures beside mean and spread over all units and draws.

    Args:
        by_unit: What `replay` gave for each unit.
        method: Whose corrected errors to show beside the raw ones.
    """
    rows = []
    for index, published in enumerate(PUBLISHED):
        raw, corrected, papers = (
            np.concatenate([errors[name][index] for errors in by_unit])
            for name in (UNCORRECTED, method, PAPERS_MODEL)
        )
        rows.append({
            "no": published.number, "position_mm": list(published.position),
            "published_raw_mm": published.raw_error, "published_z_mm": published.z_error,
            "raw_mm": np.nanmean(np.abs(raw)), "raw_std_mm": np.nanstd(raw),
            "corrected_mm": np.nanmean(np.abs(corrected)), "corrected_std_mm": np.nanstd(corrected),
            f"{PAPERS_MODEL}_mm": np.nanmean(np.abs(papers)), f"{PAPERS_MODEL}_std_mm": np.nanstd(papers),
            "trials": int(np.isfinite(corrected).sum()),
        })  # fmt: skip
    return rows
