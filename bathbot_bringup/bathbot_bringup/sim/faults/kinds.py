"""What can be made to fail in the emulated controller: one row a kind.

A row says where the fault acts and what it does there. Each place - the sensor, the push, the sessions, the
joints, the body - asks the schedule for the faults of its own and lets them act in the order of this table;
none knows a fault by name. What happens once, when a fault begins or ends, stands in the row as well.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

from bathbot_bringup.sim.faults import (
    force_faults,
    joint_faults,
    push_faults,
    pushed_surface,
    session_faults,
)
from bathbot_bringup.sim.faults.lasting_fault import Place

NONE = "none"


class Machine(Protocol):
    """What may happen to the emulated controller at once."""

    def cut_power(self) -> None:
        """Let the joints lose power."""

    def freeze(self) -> None:
        """Let the controller's program stand still."""

    def thaw(self) -> None:
        """Let it go on, with what came in meanwhile."""

    def drop_clients(self) -> None:
        """Cut off all clients."""

    def put_body_back(self) -> None:
        """Put the body where it was."""


class Kind(NamedTuple):
    """What a kind of fault does, where, and what its value means."""

    about: str  # one line
    acts: Mapping[Place, Callable[..., Any]] = {}
    value: float = math.nan  # taken when none is given; NaN: this kind has no value
    lowest: float = -math.inf
    highest: float = math.inf
    at_begin: Callable[[Machine], None] = lambda machine: None
    at_end: Callable[[Machine], None] = lambda machine: None


_SENSOR, _PUSH, _SESSIONS = Place.FORCE_SENSOR, Place.PUSH, Place.SESSIONS
_JOINTS, _BODY = Place.JOINTS, Place.BODY

KINDS: dict[str, Kind] = {
    NONE: Kind("ends all faults and those that wait, and puts the body back",
               at_begin=lambda machine: machine.put_body_back()),
    # the force sensor
    "stale_force": Kind("the force is `value` [s] old when it is pushed",
                        {_SENSOR: force_faults.stale}, 0.5, 0.005, 5.0),
    "biased_force": Kind("`value` [N] more along the sensor's z; negative: as if pressed",
                         {_SENSOR: force_faults.biased}, -12.0, -400, 400),
    "drifting_force": Kind("the force drifts by `value` [N/s] along the sensor's z",
                           {_SENSOR: force_faults.drifting}, -4.0, -400, 400),
    "saturated_force": Kind("the force stands at `value` [N] along the sensor's z",
                            {_SENSOR: force_faults.saturated}, -200.0, -400, 400),
    "frozen_force": Kind("the force sensor repeats its last reading", {_SENSOR: force_faults.frozen}),
    "dead_force": Kind("the force sensor is gone: zeros, and error 0x2003", {_SENSOR: force_faults.dead}),
    "nan_force": Kind("the force is no number: null in JSON", {_SENSOR: force_faults.no_number}),
    # the state push
    "lost_udp": Kind("no datagram leaves", {_PUSH: push_faults.lost}),
    "slow_udp": Kind("one datagram in `value` [s]", {_PUSH: push_faults.slow}, 0.3, 0.005, 60.0),
    "frozen_udp": Kind("the last datagram is sent again and again", {_PUSH: push_faults.repeated}),
    "garbled_udp": Kind("every datagram is cut off in the middle", {_PUSH: push_faults.cut_short}),
    "time_jump": Kind("datagrams are held back for `value` [s], then all come at once, again and again",
                      {_PUSH: push_faults.held_back}, 0.3, 0.005, 10.0),
    # the TCP sessions
    "dropped_tcp": Kind("clients are cut off, and new ones at once, as long as it lasts",
                        {_SESSIONS: session_faults.cut_off},
                        at_begin=lambda machine: machine.drop_clients()),
    "slow_reply": Kind("replies and events come `value` [s] late; the joint stream is taken in time",
                       {_SESSIONS: session_faults.late}, 1.0, 0.0, 60.0),
    "deaf_tcp": Kind("clients may connect; nothing is answered, nothing obeyed",
                     {_SESSIONS: session_faults.deaf}),
    # all of it
    "power_cut": Kind("no power: brakes fall in, nothing answers, TCP hangs half open; comes back with "
                      "the arm switched off",
                      {_JOINTS: joint_faults.all_braked, _PUSH: push_faults.lost,
                       _SESSIONS: session_faults.deaf},
                      at_begin=lambda machine: machine.cut_power(),
                      at_end=lambda machine: machine.drop_clients()),
    "stalled": Kind("the controller freezes: the joints go on to the last target, frames wait until it ends",
                    {_SESSIONS: session_faults.waiting},
                    at_begin=lambda machine: machine.freeze(), at_end=lambda machine: machine.thaw()),
    # the joints; who has no power reports nothing else
    "joint_error": Kind("joint `value` reports overcurrent and brakes; the arm stops",
                        {_JOINTS: joint_faults.overcurrent}, 3, 1, 6),
    "following_error": Kind("joint `value` is jammed; noticed 2 deg later, then the arm stops",
                            {_JOINTS: joint_faults.jammed}, 3, 1, 6),
    "collision_stop": Kind("the controller believes in a collision: the arm stops, error 0x100D",
                           {_JOINTS: joint_faults.collision}),
    # the person
    "body_push": Kind("the body comes towards the head with `value` [m/s], 0.3 m at most",
                      {_BODY: pushed_surface.coming}, 0.1, 0.0, 2.0),
    "body_away": Kind("the body leaves the head with `value` [m/s], 0.3 m at most",
                      {_BODY: pushed_surface.leaving}, 0.1, 0.0, 2.0),
}  # fmt: skip
