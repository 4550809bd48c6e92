"""The several joint solutions of one pose: whole turns, limits, and the one nearest to where the arm stands.

Solutions come as arrays of shape (..., B, J): B branches, whose index keeps its meaning along a path, of J
joints; NaN where a branch has none.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.arm.errors import UnreachableError
from bathbot_scrub.arm.joint_limits import JointLimits

Array = NDArray[np.float64]


def wrap(angles: ArrayLike) -> Array:
    """Bring angles [rad] into (-pi, pi]."""
    return -np.remainder(-np.asarray(angles, dtype=float) + np.pi, 2 * np.pi) + np.pi


def within_limits(solutions: ArrayLike, limits: JointLimits) -> Array:
    """Replace solutions [rad], shape (..., J), outside the limits by NaN."""
    solutions = np.asarray(solutions, dtype=float)
    return np.where(limits.contain(solutions)[..., None], solutions, np.nan)


def unwind(solutions: ArrayLike, seed: ArrayLike, limits: JointLimits) -> Array:
    """Add full turns so that each angle [rad], shape (..., J), is nearest to `seed` inside the limits."""
    solutions, seed = np.asarray(solutions, dtype=float), np.asarray(seed, dtype=float)
    near = solutions + 2 * np.pi * np.round((seed - solutions) / (2 * np.pi))
    near = np.where(near > limits.upper, near - 2 * np.pi, near)
    return np.where(near < limits.lower, near + 2 * np.pi, near)


def nearest(solutions: ArrayLike, seed: ArrayLike, limits: JointLimits) -> Array:
    """Choose the solution whose largest joint travel from `seed` is least.

    Args:
        solutions: Candidates [rad], shape (B, J), NaN where there is none.
        seed: Joint angles [rad], shape (J,).
        limits: Candidates outside are not considered.

    Returns:
        Joint angles [rad], shape (J,).

    Raises:
        UnreachableError: When no candidate lies inside the limits.
    """
    candidates = within_limits(unwind(solutions, seed, limits), limits)
    travel = np.abs(candidates - np.asarray(seed)).max(-1)
    if np.all(np.isnan(travel)):
        raise UnreachableError(
            "no joint solution inside the limits; choose a nearer target or another direction"
        )
    return candidates[int(np.nanargmin(travel))]
