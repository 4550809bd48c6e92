"""What faults do to the joints and to the body before the brush."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.faults.fault_schedule import FaultSchedule
from bathbot_bringup.sim.faults.pushed_surface import PushedSurface

Array = NDArray[np.float64]
COLLISION, JOINT_DISABLED, FORCE_SENSOR = 0x100D, 0x1010, 0x2003  # the controller's error codes
OVERCURRENT, FOLLOWING = 0x40, 0x800  # codes of one joint
_FOLLOWED = np.radians(2.0)  # off the target before the controller calls it a following error; ours


class JointTrouble(NamedTuple):
    """What is wrong with the joints in one step."""

    stuck: frozenset[int] = frozenset()  # joints, from 0, that brake whatever they are told
    error: int = 0  # for which the arm must stop; 0: none
    joint: int = 0  # from 0, whose own code is
    code: int = 0


def joint_trouble(faults: FaultSchedule, joints: Sequence[float], target: Array) -> JointTrouble:
    """Tell what is wrong with joints that are at `joints` [rad] and were told `target` [rad], (6,) each."""
    if "power_cut" in faults:
        return JointTrouble(frozenset(range(6)))
    if "joint_error" in faults:
        joint = int(faults.value("joint_error")) - 1
        return JointTrouble(frozenset({joint}), JOINT_DISABLED, joint, OVERCURRENT)
    if "following_error" in faults:
        joint = int(faults.value("following_error")) - 1
        noticed = abs(joints[joint] - target[joint]) > _FOLLOWED
        return JointTrouble(frozenset({joint}), *((JOINT_DISABLED, joint, FOLLOWING) if noticed else ()))
    if "collision_stop" in faults:
        return JointTrouble(error=COLLISION)
    return JointTrouble()


class BodyFaults:
    """Pushes the body about, one step after the other."""

    def __init__(self, surface: PushedSurface, period: float) -> None:
        """Move `surface`; `period` [s] between steps."""
        self._surface, self._period = surface, period
        self._directions: dict[str, Array] = {}

    def step(self, faults: FaultSchedule, T_base_head: Array, t: float, pressed: bool) -> None:
        """Move the body as the faults say.

        Args:
            faults: What lasts.
            T_base_head: Pose of the head, (4, 4).
            t: Time of the body [s].
            pressed: Whether the brush touches the body.
        """
        for kind, sign in (("body_push", 1.0), ("body_away", -1.0)):
            if kind not in faults:
                self._directions.pop(kind, None)
                continue
            if kind not in self._directions:  # as it is when the fault begins
                self._directions[kind] = self._surface.towards(T_base_head, t, pressed)
            self._surface.move(sign * faults.value(kind) * self._period * self._directions[kind])
