"""Between the arm's arrays and the messages of the vendor's ROS 2 driver (package rm_ros_interfaces)."""

from collections.abc import Sequence

import numpy as np
from geometry_msgs.msg import Pose
from numpy.typing import ArrayLike, NDArray
from rm_ros_interfaces.msg import Jointerrorcode, Sixforce

from bathbot_scrub.arm.errors import InvalidPoseError
from bathbot_scrub.rm65.ros.messages import checked_transforms

Array = NDArray[np.float64]
_JOINTS = 6


def sixforce_message(wrench: ArrayLike) -> Sixforce:
    """A wrench [N, Nm], shape (6,), at the sensor, in its axes."""
    fx, fy, fz, mx, my, mz = (float(value) for value in np.asarray(wrench))
    return Sixforce(force_fx=fx, force_fy=fy, force_fz=fz, force_mx=mx, force_my=my, force_mz=mz)


def joint_error_message(bits: Sequence[int]) -> Jointerrorcode:
    """Error bits of the joints."""
    return Jointerrorcode(joint_error=[int(code) & 0xFFFF for code in bits], dof=_JOINTS)


def joints_from_message(joint: Sequence[float]) -> Array:
    """Joint angles [rad], shape (6,), of a message.

    Raises:
        InvalidPoseError: When they are not six finite numbers.
    """
    joints = np.asarray(joint, dtype=float)
    if joints.shape != (_JOINTS,) or not np.isfinite(joints).all():
        raise InvalidPoseError(f"joint must hold six finite angles in rad, got {joints.tolist()}")
    return joints


def flange_from_message(pose: Pose) -> Array:
    """T_base_flange, shape (4, 4), of a message.

    Raises:
        InvalidPoseError: When it is not finite or its quaternion is not of unit length.
    """
    return checked_transforms([pose])[0]


def share_from_message(speed: int, trajectory_connect: int = 0) -> float:
    """Share of full speed, 0..1, that a move asks for in percent.

    Raises:
        InvalidPoseError: When it is not 1..100, or the move is to be chained.
    """
    if not 1 <= speed <= 100:
        raise InvalidPoseError(f"speed must be 1..100 percent, got {speed}")
    if trajectory_connect:
        raise InvalidPoseError(
            f"trajectory_connect is {trajectory_connect}, but chained moves are not supported; send 0"
        )
    return speed / 100.0
