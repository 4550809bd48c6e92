"""What is wrong with the joints: one function a fault.

Each takes where the joints are and where they were told to be [rad], (6,) each.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.faults.lasting_fault import LastingFault

Array = NDArray[np.float64]
COLLISION, JOINT_DISABLED = 0x100D, 0x1010  # the controller's error codes
OVERCURRENT, FOLLOWING = 0x40, 0x800  # codes of one joint
_FOLLOWED = np.radians(2.0)  # off the target before the controller calls it a following error; ours


class JointTrouble(NamedTuple):
    """What is wrong with the joints in one step."""

    stuck: frozenset[int] = frozenset()  # joints, from 0, that brake whatever they are told
    error: int = 0  # for which the arm must stop; 0: none
    joint: int = 0  # from 0, whose own code is
    code: int = 0


def joint_trouble(faults: Sequence[LastingFault], joints: Sequence[float], target: Array) -> JointTrouble:
    """Tell what is wrong with joints at `joints` that were told `target` [rad]; the first fault decides."""
    return faults[0](joints, target) if faults else JointTrouble()


def all_braked(fault: LastingFault, joints: Sequence[float], target: Array) -> JointTrouble:
    """Let the brakes of all joints fall in; nobody is told."""
    return JointTrouble(frozenset(range(6)))


def overcurrent(fault: LastingFault, joints: Sequence[float], target: Array) -> JointTrouble:
    """Brake one joint - its value, from 1 - and report it."""
    joint = int(fault.value) - 1
    return JointTrouble(frozenset({joint}), JOINT_DISABLED, joint, OVERCURRENT)


def jammed(fault: LastingFault, joints: Sequence[float], target: Array) -> JointTrouble:
    """Hold one joint - its value, from 1 - and report it once it is off its target."""
    joint = int(fault.value) - 1
    if abs(joints[joint] - target[joint]) > _FOLLOWED:
        return JointTrouble(frozenset({joint}), JOINT_DISABLED, joint, FOLLOWING)
    return JointTrouble(frozenset({joint}))


def collision(fault: LastingFault, joints: Sequence[float], target: Array) -> JointTrouble:
    """Believe in a collision."""
    return JointTrouble(error=COLLISION)
