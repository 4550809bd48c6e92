"""The way back on which the arm came: nothing stood in it then.

From where the head is, straight over the skin to the stand-off of the approach, and from there home as it
came. Joint 6 turns the round head about itself only, so what the path has wound up is unwound on the way.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_scrub.rm65.errors import UnreachableError
from bathbot_scrub.rm65.inverse_kinematics import wrap
from bathbot_scrub.rm65.joint_path import JointPath
from bathbot_scrub.rm65.kinematics import Kinematics, retreated
from bathbot_scrub.rm65.limits import JointLimits
from bathbot_scrub.rm65.tool_path import densify, solve_path

Array = NDArray[np.float64]
_STEP = 0.01  # [m] between samples over the skin
_FARTHEST = 0.3  # [m] from the stand-off; from farther away the skin between is not known
_SAME = 0.05  # [rad] within which two postures are one


def way_back(
    kinematics: Kinematics, start: ArrayLike, came: JointPath, home: ArrayLike, limits: JointLimits
) -> list[Array]:
    """Joints [rad] to pass after `start`, home the last.

    Args:
        kinematics: The arm.
        start: Joints now, shape (6,).
        came: From home to the stand-off.
        home: Where to end, shape (6,).
        limits: Of the joints.

    Raises:
        UnreachableError: The arm did not come from home, or its stand-off is far off or on another branch.
    """
    start, home = np.asarray(start, dtype=float), np.asarray(home, dtype=float)
    if np.abs(came.joints[0] - home).max() > _SAME:
        raise UnreachableError("the arm did not come from home")
    now, standoff = kinematics.head(start), kinematics.head(came.joints[-1])
    away = now[:3, 3] - standoff[:3, 3]
    if np.linalg.norm(away) > _FARTHEST:
        raise UnreachableError(f"the stand-off is {np.linalg.norm(away):.2f} m away, more than {_FARTHEST} m")
    over = retreated(standoff, max(float(-away @ standoff[:3, 2]), 0.0))
    _, dense = densify(np.stack([now, over, standoff]), _STEP)
    across = solve_path(kinematics, dense, start, limits)
    wound = across[-1] - came.joints[-1]
    if np.abs(wrap(wound)).max() > _SAME or np.abs(wound[:5]).max() > _SAME:
        raise UnreachableError("the arm stands on another branch than it came on")
    left = came.lengths / max(came.end, 1e-9)
    back = came.joints + left[:, None] * wound
    way = [*across[1:], *back[-2::-1], home]
    if not limits.contain(way).all():
        raise UnreachableError("on the way back a joint would pass its limit")
    return way
