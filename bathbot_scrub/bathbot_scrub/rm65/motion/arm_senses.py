"""What an arm feels: samples in; joints, force at the head, and signals for the watchdogs out.

Knows no wire and starts no thread; time is an argument.
"""

import math
import threading

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.controller.state_push import ArmSample
from bathbot_scrub.rm65.force.tool_weight import ToolWeight
from bathbot_scrub.rm65.force.wrench_filter import HeadWrench, WrenchFilter
from bathbot_scrub.rm65.guard.force_checks import Reading
from bathbot_scrub.rm65.guard.signal_health import Activity, Connected, SignalHealth, Signals
from bathbot_scrub.rm65.motion.arm_link import Sensed
from bathbot_scrub.rm65.settings import DriverSettings

Array = NDArray[np.float64]
_NOTHING = Reading(math.nan, *[np.full(6, np.nan)] * 3, (), math.inf)


class ArmSenses:
    """Takes samples as they arrive. Thread-safe: one thread takes, others command, ask and zero.

    Attributes:
        sample: Newest state of the arm; None before the first.
        wrench: Newest filtered force; None before the first.
    """

    def __init__(self, settings: DriverSettings) -> None:
        """Begin before the first sample, with filter, tool and tolerances of `settings`."""
        self.sample: ArmSample | None = None
        self.wrench: HeadWrench | None = None
        self._filter, self._filter_lock = WrenchFilter(settings.force_cutoff), threading.Lock()
        self._tool = ToolWeight(settings.tool_mass, np.array(settings.tool_centre))
        self._pull_at_zero = np.zeros(6)  # of the tool [N, Nm], in the posture of the last zeroing
        self._health = SignalHealth(settings.following_tolerance, 1.0 / settings.rate)

    def take(self, sample: ArmSample) -> None:
        """Take a sample that could be read."""
        with self._filter_lock:
            external = sample.wrench - (self._pull(sample) - self._pull_at_zero)
            self.wrench = self._filter.update(sample.stamp, external)
        self.sample = sample
        self._health.sample(sample)

    def refuse(self) -> None:
        """A datagram came that could not be read."""
        self._health.refuse()

    def exceed(self, now: float) -> None:
        """At `now` [s] a datagram came beyond those that were ordered."""
        self._health.exceed(now)

    def begin_anew(self) -> None:
        """The sensor reads zero now, with the tool in this posture."""
        sample = self.sample
        with self._filter_lock:
            self._filter.reset()
            self._pull_at_zero = np.zeros(6) if sample is None else self._pull(sample)

    def told(self, joints: Array | None, now: float) -> None:
        """Know what is commanded at `now` [s], shape (6,) [rad]; None: nothing."""
        self._health.command(joints, now)

    def sense(self, now: float) -> Sensed:
        """What was measured last, as it is at `now` [s]; NaN and an infinite age before the first sample."""
        wrench, sample = self.wrench, self.sample
        if wrench is None or sample is None:
            return Sensed(_NOTHING, np.full(6, np.nan))
        age = now - wrench.stamp
        reading = Reading(wrench.stamp, wrench.raw, wrench.filtered, wrench.sudden, wrench.trends, age)
        return Sensed(reading, sample.joints)

    def signals(self, now: float, tcp: Connected, activity: Activity) -> Signals:
        """What the watchdogs judge at `now` [s]."""
        return self._health.signals(now, tcp, activity)

    def _pull(self, sample: ArmSample) -> Array:
        return self._tool.pull(sample.T_base_flange[:3, :3])
