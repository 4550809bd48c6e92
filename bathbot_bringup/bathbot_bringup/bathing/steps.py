"""The bathing job as a sequence of steps, and when a contact target may be trusted."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from bathbot_localize.target.target import Target
from bathbot_perception.classes import SKIN_CLASSES

from bathbot_bringup.errors import InputError


class Step(NamedTuple):
    """One step of the job.

    Attributes:
        name: Short name, as in the summary's stage times.
        about: What is done, for a person.
        timeout: After which it has failed [s].
    """

    name: str
    about: str
    timeout: float


CONNECT = Step("connect", "wait for the arm and its force sensor", 15.0)
SELECT = Step("select", "choose the region", 10.0)
LOOK = Step("look", "find the region and its contact target", 30.0)
APPROACH = Step("approach", "approach until skin is felt", 40.0)
SCRUB = Step("scrub", "scrub along the skin", 120.0)
RETRACT = Step("retract", "leave along the outward normal", 15.0)
HOME = Step("home", "move the arm home", 30.0)


class Sighting(NamedTuple):
    """A contact target and the time of the picture it was found in [s]."""

    time: float
    target: Target


def full_region_name(name: str) -> str:
    """Complete a region's name: `trunk`, `Trunk` and `Trunk_skin` are the same.

    Raises:
        InputError: On an unknown region; the message lists those that exist.
    """
    wanted = name.strip().lower()
    for region in SKIN_CLASSES:
        if wanted in (region.lower(), region.removesuffix("_skin").lower()):
            return region
    raise InputError(f"no region is named {name!r}; there are {', '.join(SKIN_CLASSES)}")


def settled(sightings: Sequence[Sighting], count: int, spread: float) -> bool:
    """Tell whether the newest sightings agree.

    Args:
        sightings: In order of time.
        count: How many must agree.
        spread: How far the positions may lie from their median, along each axis [m].
    """
    if len(sightings) < count:
        return False
    positions = np.array([sighting.target.T_base_target[:3, 3] for sighting in sightings[-count:]])
    return bool(np.all(np.abs(positions - np.median(positions, axis=0)) <= spread))
