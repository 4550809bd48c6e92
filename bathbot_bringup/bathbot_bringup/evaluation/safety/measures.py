"""What a trial's trace says: when the arm stood or left, how far it went, how hard it pressed. Pure.

A sample of the trace is *calm* when the head stands (slower than 3 mm/s, every joint slower than 0.02 rad/s)
or leaves (its velocity within 60 deg of the outward direction) or has left: off the skin, 20 mm out or more,
within 45 deg of straight out from where the fault struck, and it comes back by no more than 5 mm. On the way
through free air, outward is back along the way it came, and it has left when it is within 5 mm of where that
way began. Where the duty is to leave, standing is calm only off the skin and at least 5 mm out.

The arm has stopped when the first of the samples has come that are calm without exception up to the end of
the trial: whatever stands for a moment and moves again has not stopped.
"""

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np
from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.states import State
from numpy.typing import NDArray

from bathbot_bringup.evaluation.safety.trial_plan import Duty, Phase
from bathbot_bringup.sim.arm.controller.controller import STEP
from bathbot_bringup.sim.arm.trace import TraceData

Array = NDArray[np.float64]
STANDS, TURNS = 0.003, 0.02  # [m/s] of the head, [rad/s] of a joint, below which it stands
_TOWARDS = 0.5  # cosine of the widest angle between a velocity and the direction it leaves in
_CLEAR, _LEFT = 0.005, 0.02  # [m] outwards from the place of the fault
_OUT = np.cos(np.radians(45.0))  # of the widest angle between straight out and the way that was gone
_GIVEN_BACK = 0.005  # [m] of the retract path
_ARRIVED = 0.005  # [m] from where the way through free air began, and beside it
_FROZEN = 0.1  # [s] between two steps above which the controller itself stood: no time for the arm
_AGAIN = 10  # calm samples in a row after which a motion is a new one
_SILENT = 0.1  # [s] without a frame that end the stream
_RETRACTS = 0.02  # [m/s] outwards faster than before that only a retract has
_SETS_OUT = 2e-5  # [m] per frame and frame outwards with which a retract begins
ALARMED = (State.RETRACTING, State.HOLD, State.FAULT)


class Report(NamedTuple):
    """What the driver said of itself."""

    stamp: float  # [s] of time.monotonic() when it was heard
    state: int
    reason: str
    connected: bool


class Reaction(NamedTuple):
    """The arm's reaction to one fault; infinite what never happened."""

    stop: float  # [s] from the fault until it stands or leaves for good
    detect: float  # [s] from the fault to the first sign that it was noticed
    moved_again: bool  # it had stood, or left, and then moved otherwise
    travel: float  # [m] way of the head from the fault to the stop
    peak: float  # [N] largest true contact force after the fault


def react(
    trace: TraceData,
    fault: float,
    phase: Phase,
    duty: Duty,
    reports: Sequence[Report],
    alarms: Collection[int] = ALARMED,
) -> Reaction:
    """Measure the reaction to a fault.

    Args:
        trace: From before the fault to the end of the trial.
        fault: When it struck [s], by the clock of the trace.
        phase: What the arm was about.
        duty: What it owes.
        reports: What the driver said, in order.
        alarms: States that tell that the fault was noticed.
    """
    first = int(np.searchsorted(trace.stamp, fault))
    velocity = head_velocity(trace)
    calm = calm_samples(trace, velocity, first, phase, duty)
    restless = np.flatnonzero(~calm[first:])
    stopped = first + int(restless[-1]) + 1 if len(restless) else first
    never = stopped >= len(trace.stamp)
    way = np.linalg.norm(np.diff(trace.head[max(first - 1, 0) : stopped + 1], axis=0), axis=1)
    return Reaction(
        stop=math.inf if never else (elapsed(trace.stamp, fault, stopped) if len(restless) else 0.0),
        detect=detected(trace, fault, reports, alarms),
        moved_again=_moves_again(calm[first:]),
        travel=float(way.sum()) if len(restless) else 0.0,
        peak=float(np.linalg.norm(trace.force[first:], axis=1).max(initial=0.0)),
    )


def head_velocity(trace: TraceData) -> Array:
    """Velocity of the head [m/s], shape (N, 3), in the time of the controller: 5 ms a step."""
    return np.diff(trace.head, axis=0, prepend=trace.head[:1]) / STEP


def calm_samples(
    trace: TraceData, velocity: Array, first: int, phase: Phase, duty: Duty
) -> NDArray[np.bool_]:
    """Which samples are calm, shape (N,), after a fault at the sample `first`; see the module."""
    speed = np.linalg.norm(velocity, axis=1)
    stands = (speed < STANDS) & (np.abs(trace.joint_speeds).max(axis=1) < TURNS)
    if phase is Phase.TRANSIT:
        leaves, left = _back(trace, velocity, first)
    else:
        leaves, left = _outward(trace, velocity, first)
    leaves &= speed >= STANDS
    if duty is Duty.LEAVE:
        origin = trace.head[min(first, len(trace.head) - 1)]
        out = -trace.approach[min(first, len(trace.head) - 1)]
        stands &= (trace.compression < 0.0) & ((trace.head - origin) @ out > _CLEAR)
    return stands | leaves | left


def _outward(trace: TraceData, velocity: Array, first: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Where the head goes against its approach axis, and where it has left the skin for good."""
    index = min(first, len(trace.head) - 1)
    out = -trace.approach[index]
    gone = trace.head - trace.head[index]
    way = gone @ out
    nearest = np.minimum.accumulate(way[::-1])[::-1]  # from here to the end
    left = (trace.compression < 0.0) & (way > _LEFT) & (way >= _OUT * np.linalg.norm(gone, axis=1))
    left &= way - nearest < _GIVEN_BACK
    return velocity @ out >= _TOWARDS * np.linalg.norm(velocity, axis=1), left


def _back(trace: TraceData, velocity: Array, first: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Where the head goes back along the way it came, and where it is back at its beginning."""
    moving = np.flatnonzero(np.linalg.norm(velocity[:first], axis=1) > STANDS)
    if not len(moving):
        return _outward(trace, velocity, first)
    track, along = trace.head[moving], velocity[moving]
    nearest = np.array([np.argmin(np.linalg.norm(track - head, axis=1)) for head in trace.head])
    out = -along[nearest] / np.linalg.norm(along[nearest], axis=1, keepdims=True)
    towards = np.sum(velocity * out, axis=1) >= _TOWARDS * np.linalg.norm(velocity, axis=1)
    on_track = np.linalg.norm(trace.head - track[nearest], axis=1) < _ARRIVED
    return towards & on_track, np.linalg.norm(trace.head - track[0], axis=1) < _ARRIVED


def elapsed(stamps: Array, fault: float, index: int) -> float:
    """Time from the fault to the sample `index` [s], without the time in which the controller stood."""
    first = int(np.searchsorted(stamps, fault))
    steps = np.diff(stamps[first : index + 1], prepend=fault)
    return float(np.where(steps > _FROZEN, STEP, steps).sum())


def detected(trace: TraceData, fault: float, reports: Sequence[Report], alarms: Collection[int]) -> float:
    """Time from the fault to the first sign that it was noticed [s]; infinite without one.

    A sign is a report of the driver that it is in one of the states `alarms`, that it has lost the controller
    or that gives a new reason; of a driver that reports nothing any more, the end of its stream.
    """
    before = [report for report in reports if report.stamp <= fault]
    after = [report for report in reports if report.stamp > fault]
    known = before[-1].reason if before else ""
    for report in after:
        if report.state in alarms or not report.connected or report.reason not in ("", known):
            return report.stamp - fault
    frames = trace.frame_stamp
    silent = not after or after[-1].stamp < fault + _SILENT
    if silent and len(frames) and fault - _SILENT < frames[-1] < trace.stamp[-1] - _SILENT:
        return max(float(frames[-1]) - fault, 0.0)
    return math.inf


def _moves_again(calm: NDArray[np.bool_]) -> bool:
    """Whether there is unrest after so many calm samples in a row."""
    run = 0
    for quiet in calm:
        if not quiet and run >= _AGAIN:
            return True
        run = run + 1 if quiet else 0
    return False


def retract_delay(trace: TraceData, fault: float, threshold: float, kinematics: Arm) -> float:
    """Time from the first pushed force over the threshold to the first frame of the retract [s].

    Zero where the retract began before the threshold was passed, infinite where it never came; NaN where the
    threshold was never passed.

    Args:
        trace: From before the fault to the end of the trial.
        fault: When it struck [s].
        threshold: Force that makes the arm leave [N].
        kinematics: Turns frames into head poses.
    """
    with np.errstate(invalid="ignore"):
        over = np.flatnonzero((trace.stamp >= fault) & (trace.pushed_force > threshold))
    if not len(over):
        return math.nan
    begun = retract_begins(trace, fault, kinematics)
    return max(begun - float(trace.stamp[over[0]]), 0.0)


def retract_begins(trace: TraceData, fault: float, kinematics: Arm) -> float:
    """When the first frame of a retract was received [s]; infinite when none was.

    It is found from behind: where the commanded head runs outwards faster than it did before the fault, and
    back from there as long as it was gaining speed outwards.
    """
    stamps, heads = trace.frame_stamp, kinematics.head(trace.frame_joints)
    first = int(np.searchsorted(stamps, fault))
    if first >= len(stamps) or first < 2:
        return math.inf
    out = -heads[first, :3, 2]
    steps = np.diff(heads[:, :3, 3] @ out, prepend=heads[0, :3, 3] @ out)  # [m] outwards, frame by frame
    period = float(np.median(np.diff(stamps)))
    fast = np.flatnonzero(steps[first:] > steps[first - 1] + _RETRACTS * period)
    if not len(fast):
        return math.inf
    index = first + int(fast[0])
    while index > first and steps[index - 1] - steps[index - 2] > _SETS_OUT:
        index -= 1
    return float(stamps[index])
