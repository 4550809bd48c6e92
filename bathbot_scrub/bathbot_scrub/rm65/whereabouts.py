"""Where the arm counts as standing when a motion begins. Pure."""

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.errors import NotReadyError

Array = NDArray[np.float64]
_ASTRAY = 0.03  # [rad] between command and measurement, at rest, above which the measurement counts


def whereabouts(command: Array | None, measured: Array, moving: bool) -> Array:
    """Joints [rad], shape (6,): last commanded, or measured where nothing was or the arm is elsewhere.

    Args:
        command: Joints last commanded [rad], shape (6,); None: nothing is.
        measured: Joints of the newest sample; NaN before the first.
        moving: Whether the arm moves: then it lags behind its command.

    Raises:
        NotReadyError: Neither is known.
    """
    if command is not None and (moving or np.abs(measured - command).max() <= _ASTRAY):
        return command
    if not np.isfinite(measured).all():
        raise NotReadyError("no state from the controller yet; check host, port and udp_port")
    return measured
