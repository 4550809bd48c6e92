"""How each kind of fault is brought about on a running trial, and from when its reaction counts."""

import math
import sys
import time
from functools import singledispatch
from typing import NamedTuple

import numpy as np
from bathbot_scrub.rm65.force.force_limits import shipped_force_limits
from bathbot_scrub.scrub_planner_settings import ScrubPlannerSettings

from bathbot_bringup.evaluation.safety.fault_table import (
    Frozen,
    Jammed,
    Killed,
    Nearer,
    Ordered,
    Planner,
    Sight,
)
from bathbot_bringup.evaluation.safety.trial.fake_localizer_node import Eyes
from bathbot_bringup.evaluation.safety.trial.operator_node import LastPose
from bathbot_bringup.evaluation.safety.trial.site import seen_skin
from bathbot_bringup.evaluation.safety.trial.stroke_player import spoilt
from bathbot_bringup.evaluation.safety.trial.trial_run import SpoiltTrialError, TrialRun
from bathbot_bringup.evaluation.safety.trial_plan import TrialPlan
from bathbot_bringup.sim.arm.trace import TraceData

PLAYER = "stroke_player"
WATCH = 1.2  # [s] after a fault
LATE = 1.0  # [s] of a segment
_RUN_OUT = 4.5  # [s] in which the arm must have come to the end of what it was given
_LOOK = 1.5  # [s] before the arm comes
_MOVED = 0.03  # [m] away from the arm; scrub_planner allows 0.02
_AT_END, _STAYS = 0.002, 120  # [m] of the last pose; samples: who passes by on the way is gone in less


class Struck(NamedTuple):
    """What was done, by the clock of the trace."""

    stamp: float  # [s] when it was done; for faults of the emulator the trace tells better
    kind: str = ""  # of an ordered fault
    path_end: LastPose | None = None  # of a path that was not gone on with
    until: float = math.inf  # [s] to which the reaction counts: then the arm may go on


def onset(struck: Struck, trace: TraceData, strike: object) -> float:
    """When the fault began, by the trace [s].

    Ordered faults: as the emulator noted. A body nearer than believed: when the true force is what counts as
    felt. A planner that fails: when the head comes to stay within 2 mm of the last pose it was given, for up
    to there it has good data. Skin that moved: its first picture; skin not seen: when the last picture is as
    old as the planner allows.

    Raises:
        SpoiltTrialError: When it did not begin at all.
    """
    if struck.kind:
        begun = trace.event_stamp[(trace.event_kind == struck.kind) & (trace.event_phase == "begin")]
        if not len(begun):
            raise SpoiltTrialError(f"the emulator did not begin the fault {struck.kind}")
        return float(begun[0])
    if isinstance(strike, Nearer):
        felt = np.linalg.norm(trace.force, axis=1) >= shipped_force_limits().contact
        return _first(trace, felt, "the brush did not touch")
    if struck.path_end is not None:
        near = np.linalg.norm(trace.head - struck.path_end.position, axis=1) < _AT_END
        after = trace.stamp > max(struck.stamp, struck.path_end.stamp)
        stays = (
            np.convolve(near & after, np.ones(_STAYS), "full")[_STAYS - 1 :] > _STAYS - 0.5
        )  # from here on
        return _first(trace, stays, "the path did not run out")
    return struck.stamp


def _first(trace: TraceData, condition: np.ndarray, complaint: str) -> float:
    found = np.flatnonzero(condition)
    if not len(found):
        raise SpoiltTrialError(complaint)
    return float(trace.stamp[found[0]])


@singledispatch
def strike_at(strike: object, run: TrialRun, plan: TrialPlan) -> Struck:
    """Bring the arm into the phase, let the fault happen, and watch."""
    raise TypeError(f"no strike: {strike!r}")


@strike_at.register
def _ordered(strike: Ordered, run: TrialRun, plan: TrialPlan) -> Struck:
    run.bring_about()
    fault: dict[str, float | str] = {"kind": strike.kind, "after": plan.offset, "duration": strike.duration}
    if math.isfinite(plan.value):
        fault["value"] = plan.value
    stamp = time.monotonic()
    run.operator.sim.order(fault)
    run.play(max(strike.duration + 0.5, WATCH))
    return Struck(stamp, strike.kind)


@strike_at.register
def _jammed(strike: Jammed, run: TrialRun, plan: TrialPlan) -> Struck:
    run.bring_about()
    kind, stamp = "following_error", time.monotonic()
    joint = run.operator.fastest_joint()
    run.operator.sim.order({"kind": kind, "after": plan.offset, "duration": strike.duration, "value": joint})
    run.play(WATCH)
    return Struck(stamp, kind)


@strike_at.register
def _nearer(strike: Nearer, run: TrialRun, plan: TrialPlan) -> Struck:
    stamp = time.monotonic()
    run.bring_about(strike.distance)
    run.play(WATCH + 1.0)
    return Struck(stamp)


@strike_at.register
def _frozen(strike: Frozen, run: TrialRun, plan: TrialPlan) -> Struck:
    run.bring_about()
    stamp = run.graph.freeze(strike.node)
    run.play(strike.duration)
    run.graph.thaw(strike.node)
    run.play(WATCH)
    return Struck(stamp)


@strike_at.register
def _planner(strike: Planner, run: TrialRun, plan: TrialPlan) -> Struck:
    run.bring_about()
    run.wait_until_due()
    stamp = time.monotonic()
    if strike is Planner.BAD:
        for _ in range(5):
            run.operator.send(spoilt(run.player.take()))
    if strike is not Planner.LATE:
        run.wait(_RUN_OUT)
        return Struck(stamp, path_end=run.path_end())
    run.wait_until_starved()
    run.wait(LATE)
    path_end, until = run.path_end(), time.monotonic()
    run.play(WATCH)
    return Struck(stamp, path_end=path_end, until=until)


@strike_at.register
def _killed(strike: Killed, run: TrialRun, plan: TrialPlan) -> Struck:
    if strike.node == PLAYER:
        play_elsewhere(run, plan)
    run.bring_about()
    stamp = run.graph.kill(strike.node)
    if strike.node != PLAYER:
        run.play(WATCH)
        return Struck(stamp)
    run.wait(_RUN_OUT)
    return Struck(stamp, path_end=run.path_end())


@strike_at.register
def _unseen(strike: Sight, run: TrialRun, plan: TrialPlan) -> Struck:
    run.graph.start_planner()
    with Eyes(run.graph.client, seen_skin(run.surface, run.target), run.target) as eyes:
        run.feed, run.engage = lambda: None, run.operator.scrub
        run.wait(_LOOK)
        run.bring_about()
        stamp = (
            eyes.move(_MOVED) if strike is Sight.MOVED else eyes.shut() + ScrubPlannerSettings().lost_after
        )
        run.wait(stamp - time.monotonic() + WATCH)
    return Struck(stamp)


def play_elsewhere(run: TrialRun, plan: TrialPlan) -> None:
    """Have the stroke played by a process of its own, which may be killed."""
    file = run.folder / "stroke.npz"
    np.savez(file, stroke=run.stroke, speed=plan.speed, path_id=run.player.path_id)
    module = "bathbot_bringup.evaluation.safety.trial.stroke_player_node"
    run.graph.start(PLAYER, [sys.executable, "-m", module, str(file)])
    run.wait_for_planner()
    run.feed = lambda: None
