"""What one trial is: drawn from the fault and the seed alone, so that anybody can draw it again."""

from typing import NamedTuple

import numpy as np

from bathbot_bringup.evaluation.safety.fault_table import FaultCase, Ordered, Phase

PERIOD = 0.01  # [s] of the driver's commands


class TrialPlan(NamedTuple):
    """When and where a fault strikes.

    Attributes:
        phase: What the arm is about then.
        delay: From the beginning of the phase to the order of the fault [s].
        shift: From the middle of the place, across the skin, in shares of its room, shape (2,).
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


def plan_trial(case: FaultCase, seed: int) -> TrialPlan:
    """Draw a trial: seeds walk through the phases of a fault, the rest is chance."""
    rng = np.random.default_rng([seed, *case.name.encode()])
    radius, angle = 0.4 * np.sqrt(rng.uniform()), rng.uniform(0.0, 2.0 * np.pi)
    value = float("nan")
    strike = case.strike
    if isinstance(strike, Ordered) and strike.lowest is not None and strike.highest is not None:
        whole = isinstance(strike.lowest, int)
        value = float(rng.integers(strike.lowest, strike.highest + 1)) if whole else float(
            rng.uniform(strike.lowest, strike.highest))  # fmt: skip
    return TrialPlan(
        phase=case.phases[(seed + len(case.name)) % len(case.phases)],
        delay=float(rng.uniform(0.05, 0.4)),
        shift=(float(radius * np.cos(angle)), float(radius * np.sin(angle))),
        heading=float(rng.uniform(0.0, 2.0 * np.pi)),
        speed=float(rng.uniform(0.03, 0.07)),
        value=value,
        offset=float(rng.uniform(0.0, PERIOD)),
    )
