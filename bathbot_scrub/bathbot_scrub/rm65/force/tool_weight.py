"""The weight of the tool in the sensor's reading: what changes of it when the arm turns. Pure.

The controller compensates the weight it was calibrated with. What it leaves, of mass m and centre c,
pulls with W(R) = m [R^T g; c x R^T g] at the sensor, R being the rotation of the flange in the base frame.
Zeroing takes away W at its own posture, so W(R) - W(R_zero) is left in the reading and is removed here.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.errors import InvalidPoseError

Array = NDArray[np.float64]
_GRAVITY = np.array([0.0, 0.0, -9.80665])  # [m/s^2] in the base frame: the arm stands upright
_LEAST_SPREAD = 0.3  # of the directions of gravity that an estimate needs


class ToolWeight(NamedTuple):
    """A tool, as far as the controller does not know it."""

    mass: float  # [kg]
    centre: Array  # [m] from the flange, axes of the sensor, shape (3,)

    def pull(self, rotation: ArrayLike) -> Array:
        """Weight as a wrench about the flange [N, Nm], shape (..., 6); `rotation` of it, (..., 3, 3)."""
        if not self.mass:  # the controller knows its tool, as it should: this runs for every sample
            return np.zeros((*np.shape(rotation)[:-2], 6))
        force = self.mass * (np.swapaxes(np.asarray(rotation, dtype=float), -1, -2) @ _GRAVITY)
        return np.concatenate([force, np.cross(self.centre, force)], axis=-1)


def estimate(rotations: ArrayLike, wrenches: ArrayLike) -> ToolWeight:
    """Mass and centre of what turns with the arm, from readings at rest in free air.

    Least squares of f = m R^T g + b and t = (m c) x R^T g + d with unknown offsets b and d.

    Args:
        rotations: Of the flange in the base frame, shape (N, 3, 3), three postures or more.
        wrenches: Readings there [N, Nm], shape (N, 6).

    Raises:
        InvalidPoseError: When the postures do not turn the sensor enough.
    """
    pulls = np.swapaxes(np.asarray(rotations, dtype=float), -1, -2) @ _GRAVITY
    wrenches = np.asarray(wrenches, dtype=float)
    pulls, forces, torques = (a - a.mean(0) for a in (pulls, wrenches[:, :3], wrenches[:, 3:]))
    spread = np.linalg.svd(pulls, compute_uv=False)
    if len(spread) < 2 or spread[1] < _LEAST_SPREAD * np.linalg.norm(_GRAVITY):
        raise InvalidPoseError(
            f"{len(pulls)} postures turn the sensor too little to find the weight; use three or more, "
            "a quarter turn apart about different axes"
        )
    mass = float((pulls * forces).sum() / (pulls**2).sum())
    if not mass > 0.0:
        return ToolWeight(0.0, np.zeros(3))
    # t = M x p is linear in M = m c: t = -[p]x M
    x, y, z = pulls.T
    none = np.zeros_like(x)
    rows = np.stack([none, z, -y, -z, none, x, y, -x, none], -1).reshape(-1, 3)
    moment = np.linalg.lstsq(rows, torques.ravel(), rcond=None)[0]
    return ToolWeight(mass, moment / mass)
