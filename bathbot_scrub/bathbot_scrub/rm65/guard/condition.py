"""All that the guard knows of arm and person, at one instant.

Frozen, so that it can be kept, compared and put back: a test looks at every condition that any order of
events leads to.
"""

from typing import NamedTuple

import numpy as np

from bathbot_scrub.arm.force_limits import RegionLimits
from bathbot_scrub.arm.states import Cause, State


class Condition(NamedTuple):
    """What `ForceGuard` decides by."""

    state: State
    region: RegionLimits  # whose skin may be touched
    reason: str = ""
    cause: Cause = Cause.NONE
    touching: bool = False  # on the skin, or so near that it may be
    facing: bool = False  # it has left a person, who may follow
    felt: bool = False  # the last reading that could be trusted showed a touch
    settled: bool = False  # the search has come to rest: a rise of force is the body's doing now
    waiting: str = ""  # for what the motion stands until it goes on by itself; empty: it does not
    paused_from: State | None = None
    after_retract: State = State.FREE
    off: bool = False  # while leaving: nothing is felt any more
    broken: bool = False  # it leaves for a force that comes with a fault: of the sensor, maybe
    cornered: bool = False  # it could not leave who presses now
    consent: str = ""  # why someone must allow the next motion; empty: nobody must
    doubted: float = -np.inf  # [s] stamp of the last reading that could not be trusted
    over_since: float | None = None  # [s] stamp of the first sample of the present excess
