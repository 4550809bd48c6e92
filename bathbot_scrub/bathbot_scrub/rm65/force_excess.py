"""Which limit a force passes, in plain words."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.force_limits import ForceLimits, RegionLimits

Array = NDArray[np.float64]
_REACTION = 0.08  # [s] from a rise to a head that leaves as fast: filter, period, acceleration


class Reading(NamedTuple):
    """What the guard looks at in every period."""

    wrench: Array  # [N, Nm] filtered, on the head about its tip, shape (6,)
    sudden: float  # [N] resultant, unfiltered but for single glitches
    rise: float  # [N/s] of the resultant
    age: float  # [s] since the sample arrived
    connected: bool  # TCP


def limit_passed(reading: Reading, region: RegionLimits, transit: float | None = None) -> str:
    """Name the limit of a region that a reading passes; empty when none.

    Args:
        reading: What was felt.
        region: Whose skin may be touched.
        transit: In free air, the lower limit that holds there [N].
    """
    force = np.abs(reading.wrench[:3])
    resultant, torque = float(np.linalg.norm(force)), float(np.linalg.norm(reading.wrench[3:]))
    if reading.sudden > region.hard_stop:
        return f"force {reading.sudden:.1f} N above the hard limit {region.hard_stop:g} N"
    most = region.retract if transit is None else min(region.retract, transit)
    if resultant > most:
        return f"force {resultant:.1f} N above {most:g} N" + ("" if transit is None else " in free air")
    for axis, value, limit in zip("xyz", force, region.axis, strict=True):
        if value > limit:
            return f"force {value:.1f} N along {axis} above {limit:g} N"
    return f"torque {torque:.2f} Nm above {region.torque:g} Nm" if torque > region.torque else ""


def surge(reading: Reading, limits: ForceLimits) -> str:
    """Say that a rise of force will use up the bristles before the arm can react; empty when not."""
    resultant = float(np.linalg.norm(reading.wrench[:3]))
    if reading.rise <= limits.surge or resultant + _REACTION * reading.rise <= limits.give:
        return ""
    return (
        f"force {resultant:.1f} N rises by {reading.rise:.0f} N/s, above {limits.surge:g} N/s; "
        f"beyond {limits.give:g} N the bristles have no give left"
    )
