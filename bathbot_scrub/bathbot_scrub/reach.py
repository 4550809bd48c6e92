"""Which poses of the scrub head the arm can hold, on the branch of joint angles it stands on now."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.errors import UnreachableError
from bathbot_scrub.rm65.inverse_kinematics import nearest, solve_head, wrap
from bathbot_scrub.rm65.joint_path import densify, solve_path
from bathbot_scrub.rm65.kinematics import Kinematics
from bathbot_scrub.rm65.limits import RM65_LIMITS

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_OFF_LIMITS = np.radians(5.0)  # [rad] from the limit of a joint
_OFF_STRAIGHT = np.sin(np.radians(4.0))  # of joint 5


class Reach:
    """Closed-form inverse kinematics that keeps to one branch."""

    def __init__(self, kinematics: Kinematics, joints: ArrayLike) -> None:
        """Stand on the branch of the given joint angles [rad], shape (6,)."""
        self._kinematics = kinematics
        self._joints = np.asarray(joints, dtype=float)
        solutions = solve_head(kinematics, kinematics.head(self._joints))
        chosen = nearest(solutions, self._joints)
        self._branch = int(np.nanargmin(np.abs(wrap(solutions - chosen)).max(axis=-1)))

    def holds(self, poses: ArrayLike, easily: bool = False) -> Mask:
        """Which head poses have a solution inside the limits on this branch, shape (N,).

        Args:
            poses: T_base_head, shape (N, 4, 4).
            easily: Only those off the limits and off the posture in which the wrist is straight: a path
                that passes near it would make joint 4 swing round.
        """
        solutions = solve_head(self._kinematics, poses)[..., self._branch, :]
        if not easily:
            return np.isfinite(solutions).all(axis=-1)
        bent = np.abs(np.sin(solutions[..., 4])) > _OFF_STRAIGHT
        return RM65_LIMITS.contain(solutions, _OFF_LIMITS) & bent

    def follow(self, poses: ArrayLike) -> tuple[int, str]:
        """How many head poses, shape (N, 4, 4), the arm can follow one after the other from where it stands.

        Returns:
            Their number, and why it ends there: empty when it can follow all.
        """
        poses = np.asarray(poses, dtype=float)
        lengths, dense = densify(poses)  # as the driver does: a joint may turn fast between two poses
        try:
            solve_path(self._kinematics, dense, self._joints)
        except UnreachableError as error:
            moved = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
            return int(np.searchsorted(np.cumsum(moved), lengths[error.index])), str(error)
        return len(poses), ""
