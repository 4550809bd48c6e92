"""Which limit a force passes, in plain words, and what the comfort band asks for. Pure."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.force_limits import ForceLimits, RegionLimits
from bathbot_scrub.rm65.force.wrench_filter import resultant

Array = NDArray[np.float64]
_REACTION = (
    0.08  # [s] from a rise to a head that leaves as fast: two samples, the joints' acceleration, reserve
)
_SLOWEST = 0.25  # share of the scrubbing speed that is left just below the retract threshold
_OWN_SURGE = 2.0  # times `surge`: while the head itself still moves towards the skin


class Reading(NamedTuple):
    """What the guard looks at, at every sample; wrenches on the head about its tip, [N, Nm], shape (6,)."""

    stamp: float  # [s] when the newest sample arrived
    raw: Array  # as measured
    wrench: Array  # filtered
    sudden: Array  # as measured, but for single glitches
    rise: float  # [N/s] of the resultant
    age: float  # [s] since the sample arrived


def limit_passed(wrench: Array, region: RegionLimits, transit: float | None = None) -> str:
    """Name the limit of a region that a wrench passes; empty when none.

    Args:
        wrench: What was felt, shape (6,).
        region: Whose skin may be touched.
        transit: In free air, the lower limit that holds there [N].
    """
    force, torque = resultant(wrench), resultant(wrench[3:])
    if force > region.collision:
        return f"force {force:.1f} N above the collision limit {region.collision:g} N: look after the person"
    if force > region.hard_stop:
        return f"force {force:.1f} N above the hard limit {region.hard_stop:g} N"
    most = region.retract if transit is None else min(region.retract, transit)
    if force > most:
        return f"force {force:.1f} N above {most:g} N" + ("" if transit is None else " in free air")
    for axis, value, limit in zip("xyz", wrench.tolist(), region.axis, strict=False):
        if abs(value) > limit:
            return f"force {abs(value):.1f} N along {axis} above {limit:g} N"
    return f"torque {torque:.2f} Nm above {region.torque:g} Nm" if torque > region.torque else ""


def surge(reading: Reading, limits: ForceLimits, settled: bool) -> str:
    """Say that a rise of force will use up the bristles before the arm can react; empty when not.

    Args:
        reading: What was felt.
        limits: With the rise that counts, and the force at which there is no give left.
        settled: Whether the head has come to rest on the skin; before, part of the rise is its own.
    """
    least = limits.surge if settled else _OWN_SURGE * limits.surge
    force = resultant(reading.wrench)
    if reading.rise <= least or force + _REACTION * reading.rise <= limits.give:
        return ""
    return (
        f"force {force:.1f} N rises by {reading.rise:.0f} N/s, above {least:g} N/s; "
        f"beyond {limits.give:g} N the bristles have no give left"
    )


class Comfort(NamedTuple):
    """What the comfort band says about a force."""

    speed: float  # share of the scrubbing speed that it allows, 0..1
    word: str  # one line for a person; empty inside the band


def comfort(force: float, region: RegionLimits) -> Comfort:
    """Judge a force [N] on the skin by a region's comfort band: above it the arm scrubs slower."""
    least, most = region.comfort
    if force < least:
        return Comfort(
            1.0, f"force {force:.1f} N below the comfort band from {least:g} N: the brush hardly touches"
        )
    if force <= most:
        return Comfort(1.0, "")
    share = (force - most) / (region.retract - most)
    speed = max(1.0 - (1.0 - _SLOWEST) * share, _SLOWEST)
    return Comfort(speed, f"force {force:.1f} N above the comfort band up to {most:g} N: scrubs slower")
