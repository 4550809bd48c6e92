"""Zeroing the force sensor: at rest, untouched, and not so often that a touch could hide in it."""

import math
from collections.abc import Callable

import numpy as np

from bathbot_scrub.arm.errors import NotReadyError
from bathbot_scrub.arm.force_limits import ForceLimits
from bathbot_scrub.rm65.force.wrench_filter import HeadWrench
from bathbot_scrub.rm65.timing.clock import MONOTONIC, Clock

_ON_ITS_WAY = 0.03  # [s] for samples that are older than the controller's reply
_SETTLE = 0.15  # [s] for the filter after zeroing
_WATCHED = 0.05  # [s] for which the force must be steady before it is zeroed


class Zeroing:
    """Zeroes one sensor; one call at a time."""

    def __init__(
        self,
        clear: Callable[[], None],
        newest: Callable[[], HeadWrench | None],
        restart: Callable[[], None],
        clock: Clock = MONOTONIC,
    ) -> None:
        """Prepare.

        Args:
            clear: Has the controller zero its sensor; raises ArmError when it does not.
            newest: Gives the newest force; None before the first.
            restart: Lets the filter begin anew.
            clock: By which it waits.
        """
        self._clear, self._newest, self._restart, self._clock = clear, newest, restart, clock
        self._in_question = False  # refused: a steady force is a touch, or drift
        self._vouched = False  # someone says that it is drift

    def run(self, limits: ForceLimits) -> float:
        """Zero the sensor, at rest; give the resultant [N] that remains. Blocks for a fifth of a second.

        Raises:
            NotReadyError: When the head is touched: the force is not steady, or far from the last zero.
            RefusedError: When the controller refuses.
            ArmConnectionError: Without connection.
        """
        self._check_untouched(limits)
        self._clear()
        self._clock.sleep(_ON_ITS_WAY)
        self._restart()
        self._clock.sleep(_SETTLE)
        newest = self._newest()
        residual = math.inf if newest is None else newest.force
        limits.check_zeroed(residual)
        self._vouched = self._in_question = False
        return residual

    def allow(self) -> bool:
        """Someone says that nothing touches the head: take the force for drift. False: nobody had asked."""
        asked, self._in_question = self._in_question, False
        self._vouched = self._vouched or asked
        return asked

    def _check_untouched(self, limits: ForceLimits) -> None:
        """Refuse to zero a force that changes, or one that is too high though nobody vouches for it."""
        felt, until = [], self._clock() + _WATCHED
        while self._clock() < until:
            newest = self._newest()
            felt.append(np.full(3, np.nan) if newest is None else newest.filtered[:3])
            self._clock.sleep(_WATCHED / 10.0)
        if not np.isfinite(felt).all():
            raise NotReadyError("no force is measured; check sensor and controller")
        change = float(np.ptp(felt, axis=0).max())
        if not change <= limits.zero_residual:
            raise NotReadyError(
                f"the force changes by {change:.2f} N: something touches the head; free it first"
            )
        force = float(np.linalg.norm(felt[-1]))
        if force > limits.transit and not self._vouched:
            self._in_question = True
            raise NotReadyError(
                f"{force:.1f} N are felt where nothing should be: free the head; if nothing touches it, the "
                "sensor has drifted: call arm/resume to say so, then go on"
            )
