"""Where the arm counts as standing when a motion begins. Pure."""

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.errors import NotReadyError

Array = NDArray[np.float64]
_ASTRAY = 0.03  # [rad] between command and measurement, at rest, above which the measurement counts
_SETTLING = 0.2  # [s] after the last motion in which the arm still catches up with its command


def whereabouts(command: Array | None, measured: Array, rest: float) -> Array:
    """Joints [rad], shape (6,): last commanded, or measured where nothing was or the arm is elsewhere.

    Args:
        command: Joints last commanded [rad], shape (6,); None: nothing is.
        measured: Joints of the newest sample; NaN before the first.
        rest: Time [s] since what is commanded came to rest; 0 while it moves.

    Raises:
        NotReadyError: Neither is known.
    """
    if command is not None and (rest < _SETTLING or np.abs(measured - command).max() <= _ASTRAY):
        return command
    if not np.isfinite(measured).all():
        raise NotReadyError("no state from the controller yet; check host, port and udp_port")
    return measured
