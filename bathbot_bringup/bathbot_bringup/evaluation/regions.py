"""Whether the detector finds a region in the simulated bathroom, seed by seed."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.detection.detector import Detector, load
from bathbot_perception.detection.settings import SkinDetectorSettings
from bathbot_perception.regions import overlap
from rich.console import Console
from rich.progress import track

from bathbot_bringup.files import write_json
from bathbot_bringup.sim.camera.d455_camera import D455Camera
from bathbot_bringup.sim.camera.sim_camera_settings import SimCameraSettings
from bathbot_bringup.sim.render.boxes import skin_boxes
from bathbot_bringup.sim.render.render import render
from bathbot_bringup.sim.scene import BathroomScene

FOUND = 0.5  # intersection over union with the true box from which on a region counts as found


class Look(NamedTuple):
    """What was found in one picture: the best overlap of the wanted class with a true box, and its score."""

    overlap: float
    score: float

    @property
    def found(self) -> bool:
        """Whether the box is right."""
        return self.overlap >= FOUND


def look(detector: Detector, seed: int, region: str, scenario: str) -> Look:
    """Take the camera's first picture of a seed, as the demo does, and find a region in it.

    The true boxes go round the visible skin of the person at rest.
    """
    camera, scene = D455Camera(SimCameraSettings(seed=seed, scenario=scenario)), BathroomScene(seed)
    T_base_colour = scene.T_base_camera @ np.linalg.inv(camera.unit.T_colour_depth)
    seen = render(scene.stage(), camera.unit.colour, T_base_colour)
    truths = [
        (box.left, box.top, box.right + 1, box.bottom + 1)
        for box in skin_boxes(seen.parts, seen.sides)
        if SKIN_CLASSES[box.part] == region
    ]
    found = [one for one in detector.detect(camera.shoot(0.0).colour) if one.name == region]
    if not (truths and found):
        return Look(0.0, 0.0)
    overlaps = overlap(np.array([one.box for one in found]), np.array(truths)).max(axis=1)
    best = int(np.argmax(overlaps))
    return Look(float(overlaps[best]), found[best].score)


def evaluate_regions(
    seeds: Sequence[int], region: str, scenario: str, model: str, json_file: Path | None
) -> int:
    """Look at all seeds, print who was missed, write the numbers.

    Returns:
        0 if the region was found for every seed, else 1.
    """
    console, detector = Console(highlight=False, soft_wrap=True), load(model or None, SkinDetectorSettings())
    rows: list[dict[str, Any]] = []
    for seed in track(seeds, "seeds", console=console, transient=True):
        seen = look(detector, seed, region, scenario)
        rows.append({"seed": seed, "found": seen.found, "overlap": seen.overlap, "score": seen.score})
        if not seen.found:
            console.print(f"seed {seed}: not found; the best box overlaps the true one by {seen.overlap:.2f}")
    count, overlaps = sum(row["found"] for row in rows), [row["overlap"] for row in rows]
    console.print(
        f"{region} found for {count} of {len(rows)} seeds; overlap with the true box: median "
        f"{np.median(overlaps):.2f}, least {min(overlaps):.2f}"
    )
    if json_file:
        write_json(json_file, {"simulated": True, "region": region, "found": count, "seeds": rows})
    return 0 if count == len(rows) else 1
