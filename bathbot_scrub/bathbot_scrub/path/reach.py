"""Which poses of the scrub head the arm can hold, on the branch of joint angles it stands on now."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.arm import Arm
from bathbot_scrub.arm.branches import nearest, wrap
from bathbot_scrub.arm.clearance import BodyClearance
from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.joint_limits import JointLimits
from bathbot_scrub.arm.tool_path import densify, solve_path, step_lengths

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_OFF_BODY, _OFF_BODY_AT_LEAST = 0.015, 0.007  # [m] of links; the driver insists on a little less


class Reach:
    """Closed-form inverse kinematics that keeps to one branch."""

    def __init__(self, arm: Arm, joints: ArrayLike, body: ArrayLike = ()) -> None:
        """Stand on the branch of the given joint angles [rad], shape (J,).

        Args:
            arm: Whose reach it is.
            joints: Where it stands.
            body: What the camera sees, shape (N, 3), base frame [m]; no link may come near it.
        """
        self._arm = arm
        self._body = np.reshape(np.asarray(body, dtype=float), (-1, 3))
        self._clearance = BodyClearance(arm)
        self._joints = np.asarray(joints, dtype=float)
        self._last: Array | None = None
        solutions = arm.solve_head(arm.head(self._joints))
        chosen = nearest(solutions, self._joints, arm.limits)
        self._branch = int(np.nanargmin(np.abs(wrap(solutions - chosen)).max(axis=-1)))
        self._roomy = arm.roomy_limits(chosen)

    def holds(self, poses: ArrayLike, easily: bool = False) -> Mask:
        """Which head poses have a solution inside the limits on this branch, off the body, shape (N,).

        Args:
            poses: T_base_head, shape (N, 4, 4).
            easily: Only those off the limits and off the postures in which the arm is stretched - there a
                few degrees of the skin's normal decide - or the wrist is straight: a path that passes near
                it would make joint 4 swing round.
        """
        solutions = self._arm.solve_head(poses)[..., self._branch, :]
        held = np.isfinite(solutions).all(axis=-1)
        if easily:
            held &= self._roomy.contain(solutions) & self._arm.supple(solutions)
        margin = _OFF_BODY if easily else _OFF_BODY_AT_LEAST
        if held.any():
            held[held] = self._clearance.free(solutions[held], self._body, margin)
        return held

    def follow(self, poses: ArrayLike, easily: bool = False) -> tuple[int, str]:
        """How many head poses, shape (N, 4, 4), the arm can follow one after the other from where it stands.

        Args:
            poses: T_base_head.
            easily: Only as far as all joints stay off their limits and the elbow stays bent.

        Returns:
            Their number, and why it ends there: empty when it can follow all.
        """
        try:
            self._solve(
                np.asarray(poses, dtype=float), self._joints, self._roomy if easily else self._arm.limits
            )
        except _CutShortError as cut:
            return cut.count, str(cut)
        return len(poses), ""

    def advance(self, poses: ArrayLike) -> tuple[int, str]:
        """How many more poses, shape (N, 4, 4), the arm can follow after those before; goes on to there.

        Returns:
            Their number, and why it ends there: empty when it can follow all.
        """
        poses = np.asarray(poses, dtype=float)
        before = [] if self._last is None else [self._last]
        count, why = len(poses), ""
        while count:
            knots = np.stack([*before, *poses[:count]])
            try:
                self._joints = self._solve(knots, self._joints, self._arm.limits)
            except _CutShortError as cut:
                why = why or str(cut)
                count = min(count - 1, max(cut.count - len(before), 0))
            else:
                self._last = knots[-1]
                break
        return count, why

    def _solve(self, poses: Array, seed: Array, limits: JointLimits) -> Array:
        """Joints [rad], shape (J,), at the last of head poses, shape (N, 4, 4), or a _CutShortError."""
        lengths, dense = densify(poses)  # as the driver does: a joint may turn fast between two poses
        try:
            return solve_path(self._arm, dense, seed, limits)[-1]
        except UnreachableError as error:
            count = int(np.searchsorted(np.cumsum(step_lengths(poses)), lengths[error.index]))
            raise _CutShortError(count, str(error)) from error


class _CutShortError(Exception):
    """A path that can be followed for `count` poses only."""

    def __init__(self, count: int, why: str) -> None:
        self.count = count
        super().__init__(why)
