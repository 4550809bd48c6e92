"""What is made to fail: one row per fault, with the phases it may strike in and what the arm owes then."""

import difflib
from collections.abc import Sequence
from enum import Enum
from typing import NamedTuple

from bathbot_bringup.errors import InputError

DEADLINE = 0.25  # [s] fault -> standing still or leaving
REGION = "Trunk_skin"


class Phase(Enum):
    """What the arm is about when the fault strikes."""

    TRANSIT = "transit"  # joint move through free air to the stand-off
    SEEK = "seek"  # straight on towards the skin
    REST = "rest"  # in contact, waiting
    SCRUB = "scrub"  # in contact, along a stroke


class Duty(Enum):
    """What the arm owes after a fault."""

    STILL = "stands still or leaves"
    LEAVE = "leaves the skin"


class Ordered(NamedTuple):
    """A fault of the emulated controller, ordered on `sim_fault`."""

    kind: str
    lowest: float | None = None  # of its value; None: the kind's own
    highest: float | None = None
    duration: float = 0.6  # [s] after which all is well again: the arm must not go on by itself


class Jammed(NamedTuple):
    """The joint that moves fastest does not move any more."""

    duration: float = 0.6  # [s]


class Killed(NamedTuple):
    """A process that dies at once."""

    node: str


class Frozen(NamedTuple):
    """A process that does not run for a while."""

    node: str
    duration: float  # [s]


class Planner(Enum):
    """How the planner fails."""

    SILENT = "sends no segment any more"
    LATE = "sends its next segment a second too late"
    BAD = "sends segments that are not finite"


class Sight(Enum):
    """What becomes of the skin that the real planner scrubs by."""

    MOVED = "is seen 30 mm farther away"
    LOST = "is not seen any more"


class Nearer(NamedTuple):
    """A body nearer than the target says; the fault is the touch that comes early."""

    distance: float  # [m]


Strike = Ordered | Jammed | Killed | Frozen | Planner | Sight | Nearer


class FaultCase(NamedTuple):
    """One row of the matrix."""

    name: str
    about: str
    strike: Strike
    phases: tuple[Phase, ...] = (Phase.TRANSIT, Phase.SEEK, Phase.REST, Phase.SCRUB)
    duty: Duty = Duty.STILL
    gentle: bool = False  # the peak force must stay below the retract threshold, not only the hard limit

    @property
    def breaks_graph(self) -> bool:
        """Whether a process is gone afterwards, so that the graph must be started again."""
        return isinstance(self.strike, Killed)


_TOUCHING = (Phase.REST, Phase.SCRUB)
_MOVING = (Phase.TRANSIT, Phase.SEEK, Phase.SCRUB)

FAULTS: tuple[FaultCase, ...] = (
    FaultCase("body_push", "the body comes into the brush at 100 mm/s", Ordered("body_push", 0.1, 0.1, 0.3),
              _TOUCHING, Duty.LEAVE),
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
    FaultCase("planner_silent", "no segment comes any more", Planner.SILENT, (Phase.SCRUB,)),
    FaultCase("planner_late", "a segment comes a second late", Planner.LATE, (Phase.SCRUB,)),
    FaultCase("planner_bad", "segments hold poses that are not finite", Planner.BAD, (Phase.SCRUB,)),
    FaultCase("planner_killed", "the planner's process dies", Killed("stroke_player"), (Phase.SCRUB,)),
    FaultCase("target_moved", "the camera sees the skin 30 mm farther away", Sight.MOVED, (Phase.SCRUB,)),
    FaultCase("target_lost", "the camera sees no skin any more", Sight.LOST, (Phase.SCRUB,)),
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
