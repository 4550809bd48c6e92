"""How much of the planned path was scrubbed in contact, and how hard."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
IN_CONTACT = 0.001  # [m] of bent bristles; less may be a graze


class ContactMeasures(NamedTuple):
    """Contact and force over one path.

    Attributes:
        fraction: Share of the planned poses that were passed with bent bristles, 0..1.
        comfort_fraction: Share of the time on the path with a force inside the comfort band, 0..1.
        force_mean: Mean force on the path [N].
        force_peak: Highest force of the whole run [N].
        compression_min: Least bend of the bristles on the path [m].
        compression_max: Strongest bend of the bristles on the path [m].
    """

    fraction: float
    comfort_fraction: float
    force_mean: float
    force_peak: float
    compression_min: float
    compression_max: float


def in_contact(passed: ArrayLike, times: ArrayLike, compression: ArrayLike) -> NDArray[np.bool_]:
    """Tell at which planned poses the bristles were bent.

    Args:
        passed: When the head passed each planned pose [s], NaN where it never did, shape (M,).
        times: Of the contact samples [s], increasing, shape (N,).
        compression: How far the bristles were bent then [m], shape (N,).
    """
    passed, times = np.asarray(passed, dtype=float), np.asarray(times, dtype=float)
    if len(times) == 0:
        return np.zeros(passed.shape, dtype=bool)
    bent = np.interp(np.nan_to_num(passed, nan=times[0]), times, np.asarray(compression, dtype=float))
    return np.isfinite(passed) & (bent >= IN_CONTACT)


def contact_measures(
    passed: ArrayLike,
    times: ArrayLike,
    compression: ArrayLike,
    force: ArrayLike,
    comfort: tuple[float, float],
) -> ContactMeasures:
    """Sum up one path; numbers that cannot be known are NaN.

    Args:
        passed: When the head passed each planned pose [s], NaN where it never did, shape (M,).
        times: Of the contact samples [s], increasing, shape (N,).
        compression: How far the bristles were bent then [m], shape (N,).
        force: Resultant force then [N], shape (N,).
        comfort: Band of the region [N], of the force limits.
    """
    passed, times = np.asarray(passed, dtype=float), np.asarray(times, dtype=float)
    compression, force = np.asarray(compression, dtype=float), np.asarray(force, dtype=float)
    touching = in_contact(passed, times, compression)
    known = passed[np.isfinite(passed)]
    on_path = (
        (times >= known.min()) & (times <= known.max()) if len(known) else np.zeros(len(times), dtype=bool)
    )
    if not on_path.any():
        peak = float(force.max()) if len(force) else np.nan
        return ContactMeasures(0.0, 0.0, np.nan, peak, np.nan, np.nan)
    comfortable = (force[on_path] >= comfort[0]) & (force[on_path] <= comfort[1])
    return ContactMeasures(
        fraction=float(touching.mean()),
        comfort_fraction=float(comfortable.mean()),
        force_mean=float(force[on_path].mean()),
        force_peak=float(force.max()),
        compression_min=float(compression[on_path].min()),
        compression_max=float(compression[on_path].max()),
    )
