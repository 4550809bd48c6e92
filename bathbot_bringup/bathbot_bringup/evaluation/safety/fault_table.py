"""What is made to fail: one row a fault, with its injection, when it may strike, and what the arm owes."""

import difflib
from collections.abc import Sequence
from typing import NamedTuple

from bathbot_bringup.errors import InputError
from bathbot_bringup.evaluation.safety.trial.fault_injection import (
    BadPlanner,
    Coming,
    Frozen,
    Injection,
    Jammed,
    Killed,
    KilledPlanner,
    LatePlanner,
    LeaningIn,
    Nearer,
    Ordered,
    SilentPlanner,
    SkinLost,
    SkinMoved,
)
from bathbot_bringup.evaluation.safety.trial_plan import Duty, Phase, TrialPlan, plan_trial


class FaultCase(NamedTuple):
    """One row of the matrix."""

    name: str
    about: str
    injection: Injection
    phases: tuple[Phase, ...] = (Phase.TRANSIT, Phase.SEEK, Phase.REST, Phase.SCRUB)
    duty: Duty = Duty.STILL
    gentle: bool = False  # the peak force must stay below the retract threshold, not only the hard limit

    def plan(self, seed: int) -> TrialPlan:
        """Draw the trial of a seed."""
        return plan_trial(self.name, self.phases, self.injection.strength, seed)


_TOUCHING = (Phase.REST, Phase.SCRUB)
_MOVING = (Phase.TRANSIT, Phase.SEEK, Phase.SCRUB)

FAULTS: tuple[FaultCase, ...] = (
    FaultCase("body_push", "the body comes into the brush at 100 mm/s", Ordered("body_push", 0.1, 0.1, 0.3),
              _TOUCHING, Duty.LEAVE),
    FaultCase("body_slow", "the body comes into the brush at 5 to 100 mm/s", Coming("body_push", 0.005, 0.1),
              _TOUCHING, Duty.LEAVE, gentle=True),
    FaultCase("body_fast", "the body comes into the brush at 100 to 200 mm/s", Coming("body_push", 0.1, 0.2),
              _TOUCHING, Duty.LEAVE),
    FaultCase("body_lean", "the person leans 40 to 200 mm into the way, at 200 mm/s",
              LeaningIn("body_push", 0.04, 0.2), (Phase.TRANSIT,)),
    FaultCase("body_nearer", "the body is 20 mm nearer than believed", Nearer(0.02), (Phase.SEEK,),
              gentle=True),
    FaultCase("force_step", "the force rises at once by 12 to 25 N",
              Ordered("biased_force", -25.0, -12.0, 0.3), _TOUCHING, Duty.LEAVE),
    FaultCase("biased_force", "the force reads 5 to 12 N too much, as if pulled",
              Ordered("biased_force", 5.0, 12.0)),
    FaultCase("saturated_force", "the force sensor reads 200 N", Ordered("saturated_force")),
    FaultCase("stale_force", "the force is half a second old", Ordered("stale_force", 0.4, 0.6),
              (Phase.SEEK, *_TOUCHING)),
    FaultCase("frozen_force", "the force sensor repeats one reading", Ordered("frozen_force")),
    FaultCase("nan_force", "the force is no number", Ordered("nan_force")),
    FaultCase("dead_force", "the force sensor is gone: zeros and an error code", Ordered("dead_force")),
    FaultCase("lost_udp", "no state datagram comes", Ordered("lost_udp")),
    FaultCase("slow_udp", "one state datagram in 0.2 to 0.4 s", Ordered("slow_udp", 0.2, 0.4, 2.5)),
    FaultCase("frozen_udp", "the same state datagram again and again", Ordered("frozen_udp")),
    FaultCase("garbled_udp", "state datagrams are cut off", Ordered("garbled_udp")),
    FaultCase("time_jump", "state datagrams come 0.2 to 0.4 s late, in a burst",
              Ordered("time_jump", 0.2, 0.4, 2.5)),
    FaultCase("dropped_tcp", "the connection is cut", Ordered("dropped_tcp")),
    FaultCase("deaf_tcp", "the controller answers and obeys nothing", Ordered("deaf_tcp")),
    FaultCase("slow_reply", "replies come a second late", Ordered("slow_reply", 1.0, 1.0, 1.0)),
    FaultCase("joint_error", "a joint reports overcurrent and brakes", Ordered("joint_error", 1, 6)),
    FaultCase("following_error", "the joint that moves fastest jams", Jammed(), _MOVING),
    FaultCase("collision_stop", "the controller believes in a collision", Ordered("collision_stop")),
    FaultCase("power_cut", "the controller has no power", Ordered("power_cut")),
    FaultCase("controller_stalled", "the controller's program freezes, its joints go on", Ordered("stalled")),
    FaultCase("controller_frozen", "the controller stands still altogether for half a second",
              Frozen("sim_rm65", 0.5)),
    FaultCase("driver_frozen", "the driver's process stands still for half a second",
              Frozen("rm65_driver", 0.5)),
    FaultCase("planner_silent", "no segment comes any more", SilentPlanner(), (Phase.SCRUB,)),
    FaultCase("planner_late", "a segment comes a second late", LatePlanner(), (Phase.SCRUB,)),
    FaultCase("planner_bad", "segments hold poses that are not finite", BadPlanner(), (Phase.SCRUB,)),
    FaultCase("planner_killed", "the planner's process dies", KilledPlanner(), (Phase.SCRUB,)),
    FaultCase("target_moved", "the camera sees the skin 30 mm farther away", SkinMoved(), (Phase.SCRUB,)),
    FaultCase("target_lost", "the camera sees no skin any more", SkinLost(), (Phase.SCRUB,)),
    FaultCase("driver_killed", "the driver's process dies", Killed("rm65_driver")),
)  # fmt: skip


def choose_faults(names: Sequence[str] = ()) -> list[FaultCase]:
    """Rows by name, in the order of the table; all of them when none is named.

    Raises:
        InputError: On an unknown name; the message lists those that exist.
    """
    known = [case.name for case in FAULTS]
    for name in names:
        if name not in known:
            close = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {close[0]}? " if close else ""
            raise InputError(f"no fault is named {name!r}; {hint}there are {', '.join(known)}")
    return [case for case in FAULTS if not names or case.name in names]
