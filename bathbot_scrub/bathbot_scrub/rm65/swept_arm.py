"""The arm's capsules at samples of a path that lie so close together that nothing fits between them."""

from typing import NamedTuple

import numpy as np
from bathbot_localize.arm_shape import ArmCapsule
from numpy.typing import NDArray

from bathbot_scrub.rm65.kinematics import LINK_NAMES, T_FLANGE_HEAD, Kinematics

Array = NDArray[np.float64]
_STRIDE = 0.005  # [m] that no end of a capsule moves farther between two samples, within one given step


class SweptArm(NamedTuple):
    """Where the capsules are at the samples, and how far they stray between these."""

    joints: Array  # (N, 6) [rad] of the samples
    ends: Array  # (N, C, 2, 3) of the capsules' axes, base frame [m]
    stray: Array  # (N,) [m] that any part of the arm is off the nearest sample, half-way to the next


def swept(kinematics: Kinematics, capsules: tuple[ArmCapsule, ...], joints: Array) -> SweptArm:
    """Thin out a dense joint path.

    A point of a capsule lies between the ends of its axis, so it moves no farther than they do.

    Args:
        kinematics: The arm.
        capsules: In the frames of the links.
        joints: Closely spaced, shape (M, 6) [rad]; first and last are kept.
    """
    ends = capsule_ends(kinematics, capsules, joints)
    steps = np.linalg.norm(np.diff(ends, axis=0), axis=-1).max(axis=(1, 2))
    way = np.concatenate([[0.0], np.cumsum(steps)])
    kept = np.unique(
        np.concatenate([[0], np.flatnonzero(np.diff(np.floor(way / _STRIDE))) + 1, [len(way) - 1]])
    )
    gaps = np.diff(way[kept])
    stray = 0.5 * np.maximum(np.append(gaps, 0.0), np.insert(gaps, 0, 0.0))
    return SweptArm(joints[kept], ends[kept], stray)


def capsule_ends(kinematics: Kinematics, capsules: tuple[ArmCapsule, ...], joints: Array) -> Array:
    """Ends of the capsules' axes, shape (N, C, 2, 3), base frame [m], for joints (N, 6) [rad]."""
    frames = kinematics.link_frames(joints)
    frames = np.concatenate([frames, frames[:, -1:] @ T_FLANGE_HEAD], axis=1)
    places = [LINK_NAMES.index(c.link) if c.link in LINK_NAMES else len(LINK_NAMES) for c in capsules]
    local = np.array([(c.start, c.end) for c in capsules])
    frames = frames[:, places]
    ends = np.einsum("ncij,cej->ncei", frames[..., :3, :3], local) + frames[:, :, None, :3, 3]
    return np.ascontiguousarray(ends)
