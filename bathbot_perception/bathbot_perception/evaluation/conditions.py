"""Conditions under which the detector is tried, each at three stated strengths (the paper's Fig. 9 B-D)."""

import hashlib
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_perception.evaluation import effects
from bathbot_perception.evaluation.effects import Picture, Random

Array = NDArray[np.floating]
STRENGTHS = ("mild", "middle", "strong")


class Condition(NamedTuple):
    """One disturbance; `values` belong to the three strengths."""

    meaning: str
    values: tuple[float, float, float]
    disturb: Callable[[Picture, Array, float, Random], Picture]


def _steam(picture: Picture, boxes: Array, density: float, random: Random) -> Picture:
    return effects.veil(picture, density, 0.25, 215.0, random)


def _dark(picture: Picture, boxes: Array, gain: float, random: Random) -> Picture:
    return effects.exposed(picture, gain, 3.0, random)


def _bright(picture: Picture, boxes: Array, gain: float, random: Random) -> Picture:
    return effects.exposed(picture, gain, 0.0, random)


def _occlusion(picture: Picture, boxes: Array, share: float, random: Random) -> Picture:
    return effects.covered(picture, boxes, share, random)


def _blur(picture: Picture, boxes: Array, share: float, random: Random) -> Picture:
    return effects.unsharp(picture, share * max(picture.shape))


def _motion(picture: Picture, boxes: Array, share: float, random: Random) -> Picture:
    length = max(round(share * max(picture.shape)), 3)
    return effects.smear(picture, length, random.uniform(0.0, np.pi))


def _wet(picture: Picture, boxes: Array, share: float, random: Random) -> Picture:
    return effects.glints(picture, share, 1.2, 200.0, random)


def _drops(picture: Picture, boxes: Array, count: float, random: Random) -> Picture:
    return effects.drops(picture, round(count), round(0.03 * max(picture.shape)), random)


CONDITIONS: Mapping[str, Condition] = {
    "steam": Condition("share of grey before the picture, up to 0.25 more", (0.15, 0.3, 0.5), _steam),
    "dark": Condition("share of the light", (0.4, 0.2, 0.08), _dark),
    "bright": Condition("times the light", (1.6, 2.5, 4.0), _bright),
    "occlusion": Condition("share of every region hidden", (0.1, 0.2, 0.35), _occlusion),
    "blur": Condition("standard deviation, as a share of the longer side", (0.002, 0.004, 0.008), _blur),
    "motion_blur": Condition("length, as a share of the longer side", (0.008, 0.016, 0.032), _motion),
    "wet_highlights": Condition("share of pixels that glint", (0.003, 0.01, 0.03), _wet),
    "drops": Condition("drops on the lens", (10.0, 25.0, 60.0), _drops),
}


def disturbed(picture: Picture, boxes: Array, name: str, strength: str, seed: str) -> Picture:
    """A picture under a condition; the same for the same seed, such as the picture's name.

    Args:
        picture: RGB uint8, shape (h, w, 3).
        boxes: Of the true regions [px], shape (n, 4); occlusion hides parts of these.
        name: A key of `CONDITIONS`.
        strength: One of `STRENGTHS`.
        seed: Any text.
    """
    condition = CONDITIONS[name]
    digest = hashlib.sha256(f"{name} {seed}".encode()).digest()
    random = np.random.default_rng(int.from_bytes(digest[:8], "big"))
    return condition.disturb(picture, boxes, condition.values[STRENGTHS.index(strength)], random)
