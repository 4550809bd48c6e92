"""How light the skin in a picture is: the individual typology angle (ITA), of dermatology.

ITA = atan((L* - 50) / b*) [deg] over CIELAB: above 55 very light, 41 to 55 light, 28 to 41 intermediate,
10 to 28 tan, -30 to 10 brown, below dark (Chardon, Cretois and Hourseau 1991). In a photo it also measures
the light: pictures are only put in order by it.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_perception.classes import SKIN_CLASSES
from bathbot_perception.regions import Region

THIRDS = ("lightest", "middle", "darkest")
_MIDDLE = 0.5  # share of a box, about its middle, that is looked at: mostly skin


def typology_angle(rgb: NDArray[np.uint8], regions: Sequence[Region]) -> float:
    """ITA [deg] of a picture: median over the middle of its largest face, else of the next class there is.

    Args:
        rgb: Shape (h, w, 3).
        regions: The true ones.

    Returns:
        NaN without regions.
    """
    for name in SKIN_CLASSES:
        mine = [region for region in regions if region.name == name]
        if mine:
            return _angle(rgb, max(mine, key=lambda region: region.size[0] * region.size[1]))
    return float("nan")


def _angle(rgb: NDArray[np.uint8], region: Region) -> float:
    (u, v), (width, height) = region.centre, region.size
    rows = slice(int(v - _MIDDLE * height / 2), int(v + _MIDDLE * height / 2) + 1)
    columns = slice(int(u - _MIDDLE * width / 2), int(u + _MIDDLE * width / 2) + 1)
    patch = np.ascontiguousarray(rgb[rows, columns], dtype=np.float32) / 255.0
    lab = cv2.cvtColor(patch, cv2.COLOR_RGB2LAB).reshape(-1, 3)
    lightness, yellow = np.median(lab[:, 0]), np.median(lab[:, 2])
    return float(np.degrees(np.arctan2(lightness - 50.0, max(yellow, 1e-3))))


def thirds(angles: Sequence[float]) -> list[str]:
    """Name of each picture's third by ITA, as in `THIRDS`; empty where the angle is NaN."""
    known = np.array([angle for angle in angles if np.isfinite(angle)])
    if not len(known):
        return [""] * len(angles)
    low, high = np.quantile(known, [1 / 3, 2 / 3])
    return [
        "" if not np.isfinite(a) else THIRDS[0] if a > high else THIRDS[2] if a < low else THIRDS[1]
        for a in angles
    ]
