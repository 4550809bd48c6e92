"""What the driver asks of the link to an arm's controller, whatever that speaks."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.controller.state_push import ArmSample
from bathbot_scrub.rm65.force.wrench_filter import HeadWrench
from bathbot_scrub.rm65.force.zeroing import Zeroing
from bathbot_scrub.rm65.guard.force_checks import Reading
from bathbot_scrub.rm65.guard.signal_health import Activity, Signals

Array = NDArray[np.float64]


class Sensed(NamedTuple):
    """What was measured last."""

    reading: Reading
    joints: Array  # [rad], shape (J,); NaN before the first sample


class LinkCounts(NamedTuple):
    """What has come over the link so far."""

    samples: int
    samples_refused: int
    protocol_errors: int


class ArmLink(Protocol):
    """Samples and forces from a controller, joint commands to it; all of it from any thread.

    Attributes:
        zeroing: Zeroes the force sensor.
        trouble: Why it is not connected, or does not work as it should; empty when all is well.
    """

    zeroing: Zeroing
    trouble: str

    @property
    def sample(self) -> ArmSample | None:
        """Newest state of the arm; None before the first."""

    @property
    def wrench(self) -> HeadWrench | None:
        """Newest filtered force; None before the first."""

    def start(self, lost: Callable[[], None], news: Callable[[], None]) -> None:
        """Begin to connect; `lost` is called when the connection is lost, `news` at every sample."""

    @property
    def connected(self) -> bool:
        """Whether the controller is set up and hears us."""

    def sense(self, now: float) -> Sensed:
        """What was measured last, as it is at `now` [s]; NaN and an infinite age before the first sample."""

    def signals(self, now: float, activity: Activity) -> Signals:
        """What the watchdogs judge, at `now` [s]."""

    def stream(self, joints: Array) -> None:
        """Command joints [rad], shape (J,), one period after the last; does not wait."""

    def told(self, joints: Array | None, now: float) -> None:
        """Know what is commanded at `now` [s], (J,) [rad], to judge whether the arm follows; or None."""

    def stop_behind(self) -> None:
        """Have the arm stopped behind all commands that still wait; does not wait."""

    def clear_errors(self) -> None:
        """Ask the controller to forget the errors it keeps.

        Raises:
            ArmError: When it refuses or does not answer.
        """

    def counts(self) -> LinkCounts:
        """What has come so far."""

    def close(self) -> None:
        """End everything."""
