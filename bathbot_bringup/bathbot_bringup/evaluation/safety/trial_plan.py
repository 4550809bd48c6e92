"""What one trial is: drawn from the fault and the seed alone, so that anybody can draw it again."""

from collections.abc import Callable, Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np

REGION = "Trunk_skin"
DEADLINE = 0.25  # [s] fault -> standing still or leaving
PERIOD = 0.01  # [s] of the driver's commands


class Phase(Enum):
    """What the arm is about when the fault strikes."""

    TRANSIT = "transit"  # joint move through free air to the stand-off
    SEEK = "seek"  # straight on towards the skin
    REST = "rest"  # in contact, waiting
    SCRUB = "scrub"  # in contact, along a stroke


class Duty(Enum):
    """What the arm owes after a fault."""

    STILL = "stands still or leaves"
    LEAVE = "leaves the skin"


class TrialPlan(NamedTuple):
    """When and where a fault strikes.

    Attributes:
        phase: What the arm is about then.
        delay: From the beginning of the phase to the order of the fault [s].
        shift: From the middle of the site, across the skin, in shares of its room, shape (2,).
        heading: Direction of the stroke, about the outward normal [rad].
        speed: Of the stroke [m/s].
        value: Strength of an ordered fault; NaN where the kind's own is meant.
        offset: Within a period of the driver's commands [s]: the emulator waits so long.
    """

    phase: Phase
    delay: float
    shift: tuple[float, float]
    heading: float
    speed: float
    value: float
    offset: float


def plan_trial(
    name: str, phases: Sequence[Phase], strength: Callable[[np.random.Generator], float], seed: int
) -> TrialPlan:
    """Draw a trial: seeds walk through the phases of a fault, the rest is chance.

    Args:
        name: Of the fault.
        phases: In which it may strike.
        strength: Draws how strong it is.
        seed: Of the trial.
    """
    rng = np.random.default_rng([seed, *name.encode()])
    radius, angle = 0.4 * np.sqrt(rng.uniform()), rng.uniform(0.0, 2.0 * np.pi)
    value = strength(rng)
    return TrialPlan(
        phase=phases[(seed + len(name)) % len(phases)],
        delay=float(rng.uniform(0.05, 0.4)),
        shift=(float(radius * np.cos(angle)), float(radius * np.sin(angle))),
        heading=float(rng.uniform(0.0, 2.0 * np.pi)),
        speed=float(rng.uniform(0.03, 0.07)),
        value=value,
        offset=float(rng.uniform(0.0, PERIOD)),
    )
