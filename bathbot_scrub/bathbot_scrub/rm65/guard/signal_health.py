"""What the watchdogs look at: counted and timed from samples and commands. Pure; time is an argument."""

import math
import threading
from collections import OrderedDict
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_scrub.rm65.arm.limits import RM65_LIMITS
from bathbot_scrub.rm65.controller.state_push import ArmSample
from bathbot_scrub.rm65.force.wrench_filter import common
from bathbot_scrub.rm65.guard.following_error import NO_LAG, FollowingMonitor, Lag

Array = NDArray[np.float64]
_TOGETHER = 0.001  # [s] between samples that arrive together: they were late
_KEPT = 400  # readings of the force that are remembered, 2 s
_BURST_COUNTS = 0.05  # [s] for which a burst is told
_UNEVEN = 0.015  # [s] by which samples may arrive closer together than they were measured


class Connected(NamedTuple):
    """What the TCP side says."""

    connected: bool
    reason: str  # why not
    unanswered: float  # [s] for which a question has waited for its answer; 0: none waits
    powered: bool = True


class Activity(NamedTuple):
    """What the arm does."""

    starved: bool  # at rest at the end of what is queued, and the path is not finished
    idle: float  # [s] on the skin without any motion
    path_open: bool  # a path was begun and is not finished
    waits_for: str = ""  # what the head on the skin waits for, in words


class Signals(NamedTuple):
    """Everything the watchdogs judge, at one instant."""

    age: float  # [s] since the newest readable sample
    refused: int  # datagrams since then that could not be read
    late: int  # most samples that lately arrived together
    finite: bool  # the force is a number
    repeats: int  # newest readings of the force in a row that had come before
    wrench: Array  # (6,) at the sensor, what two samples in a row have at least [N, Nm]
    errors: tuple[int, ...]
    joint_errors: tuple[int, ...]
    lag: Lag
    tcp: Connected
    activity: Activity
    excess: bool = False  # lately more datagrams came than were ordered
    leap: int = 0  # joint, counted from 1, that lately went farther between two samples than it can; 0: none


class SignalHealth:
    """Collects the signals. Thread-safe: one thread takes samples, another commands and asks."""

    def __init__(self, tolerance: float, period: float) -> None:
        """Begin before the first sample; `tolerance` [rad] and `period` [s] as of `FollowingMonitor`."""
        self._lock = threading.Lock()
        self._sample: ArmSample | None = None
        self._before: Array | None = None
        self._readings: OrderedDict[bytes, None] = OrderedDict()
        self._repeats, self._together, self._refused = 0, 1, 0
        self._late, self._late_at = 0, -math.inf
        self._excess_at, self._leap, self._leapt_at = -math.inf, 0, -math.inf
        self._following, self._lag = FollowingMonitor(tolerance, period), NO_LAG

    def sample(self, sample: ArmSample) -> None:
        """Take a sample that could be read."""
        with self._lock:
            last = self._sample
            if last is not None:
                self._repeats = self._repeats + 1 if self._known(sample.wrench) else 0
                self._together = self._together + 1 if sample.stamp - last.stamp < _TOGETHER else 1
                self._before = last.wrench
                self._note_leap(last, sample)
            if self._together > 1 and (
                self._together > self._late or sample.stamp - self._late_at > _BURST_COUNTS
            ):
                self._late, self._late_at = self._together, sample.stamp
            self._sample, self._refused = sample, 0

    def _known(self, wrench: Array) -> bool:
        """Whether this very reading came before, in the last two seconds; noise never repeats itself."""
        if not np.isfinite(wrench).all():
            return False
        reading = wrench.tobytes()
        known = reading in self._readings
        self._readings[reading] = None
        if len(self._readings) > _KEPT:
            self._readings.popitem(last=False)
        return known

    def _note_leap(self, last: ArmSample, sample: ArmSample) -> None:
        """Two sources, or old data, give themselves away by joints that are in two places."""
        most = RM65_LIMITS.speed * (max(sample.stamp - last.stamp, 0.0) + _UNEVEN)
        beyond = np.abs(sample.joints - last.joints) - most
        if beyond.max() > 0.0:
            self._leap, self._leapt_at = int(beyond.argmax()) + 1, sample.stamp

    def exceed(self, now: float) -> None:
        """At `now` [s] a datagram came beyond those that were ordered."""
        with self._lock:
            self._excess_at = now

    def refuse(self) -> None:
        """A datagram came that could not be read."""
        with self._lock:
            self._refused += 1

    def command(self, joints: Array | None, now: float) -> None:
        """Take what is commanded at `now` [s], joints [rad], shape (6,); None: the stream rests."""
        with self._lock:
            if joints is None or self._sample is None:
                self._following.forget()
                self._lag = NO_LAG
            else:
                self._lag = self._following.command(joints, self._sample.joints, now - self._sample.stamp)

    def signals(self, now: float, tcp: Connected, activity: Activity) -> Signals:
        """What is known at `now` [s], on the clock of the stamps."""
        with self._lock:
            sample, before = self._sample, self._before
            excess = now - self._excess_at <= _BURST_COUNTS
            leap = self._leap if now - self._leapt_at <= _BURST_COUNTS else 0
            late = self._late if now - self._late_at <= _BURST_COUNTS else 0
            if sample is None:
                nothing = np.full(6, np.nan)
                return Signals(
                    math.inf, self._refused, 0, True, 0, nothing, (), (), self._lag, tcp, activity, excess
                )  # fmt: skip
            wrench = sample.wrench if before is None else common(sample.wrench, before)
            return Signals(
                max(now - sample.stamp, 0.0),
                self._refused,
                late,
                bool(np.isfinite(sample.wrench).all()),
                self._repeats,
                wrench,
                sample.errors,
                sample.joint_errors,
                self._lag,
                tcp,
                activity,
                excess,
                leap,
            )
