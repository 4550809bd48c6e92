"""Which limit a force passes, in plain words, and what the comfort band asks for. Pure."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.arm.force_limits import ForceLimits, RegionLimits
from bathbot_scrub.rm65.force.wrench_filter import Trend, resultant

Array = NDArray[np.float64]
_REACTION = (
    0.08  # [s] from a rise to a head that leaves as fast: two samples, the joints' acceleration, reserve
)
_SLOWEST = 0.25  # share of the scrubbing speed that is left just below the retract threshold
_OWN_SURGE = 2.0  # times `surge`: while the head itself still moves towards the skin
_SURGE_COUNT = 5  # samples to which `surge` belongs; the slope of more of them is known better


class Reading(NamedTuple):
    """What the guard looks at, at every sample; wrenches on the head about its tip, [N, Nm], shape (6,)."""

    stamp: float  # [s] when the newest sample arrived
    raw: Array  # as measured
    wrench: Array  # filtered
    sudden: Array  # as measured, but for single glitches
    trends: tuple[Trend, ...]  # of the resultant, over windows of several lengths, the shortest first
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


def surge(trends: tuple[Trend, ...], limits: ForceLimits, settled: bool) -> str:
    """Say that the bristles' give is used up, or will be before the arm can react; empty when not.

    A rise counts from where it is `surge` over 20 ms, 7.9 times what the sensor's noise alone gives; over 40
    and 80 ms the noise gives less, so slower rises count.

    Args:
        trends: Of the force, the one over the longest window last.
        limits: With the rise that counts, and the force at which there is no give left.
        settled: Whether the head has come to rest on the skin; before, part of the rise is its own.
    """
    for trend in trends:
        least = noise_ratio(trend.count) * limits.surge * (1.0 if settled else _OWN_SURGE)
        if trend.rise > least and trend.force + _REACTION * trend.rise > limits.give:
            return (
                f"force {trend.force:.1f} N rises by {trend.rise:.0f} N/s, above {least:.0f} N/s; "
                f"beyond {limits.give:g} N the bristles have no give left"
            )
    if trends and trends[-1].force > limits.used_up:
        return (
            f"force {trends[-1].force:.1f} N above {limits.used_up:g} N: the bristles' give, "
            f"{limits.give:g} N, is used up but for what the zero may be off"
        )
    return ""


def noise_ratio(count: int) -> float:
    """Noise of the slope through so many samples, over that of the window to which `surge` belongs."""
    return math.sqrt(_SURGE_COUNT * (_SURGE_COUNT**2 - 1) / (count * (count**2 - 1)))


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
