"""Running mean of a target over the last frames: lowers the noise, does not follow a moving body late.

Only frames that agree with the newest one are averaged: the same region, a pixel not far away, and
a position that differs along the normal by no more than the noise explains. A breathing chest
leaves that band after one frame or two, so the mean then holds the newest frames alone.
"""

from collections import deque

import numpy as np
from bathbot_depthcorr.geometry.rigid import Array, transform_from

from bathbot_localize.target.target import Target, pose_from_normal

FRAMES = 5  # N, how many frames are averaged at most
_PIXELS = 6.0  # [px] within which the target counts as the same place
_AGREE = 2.5  # [standard deviations] of a difference along the normal
_AGE = 1.0  # [s] older frames are forgotten
# Half of the variance is frozen in the scene (texture of the skin) and does not average out.
_FROZEN = 0.5


class TargetSmoother:
    """Averages the targets of one region."""

    def __init__(self, frames: int = FRAMES) -> None:
        """Average at most `frames` frames; 1 switches averaging off."""
        self._kept: deque[tuple[float, Target]] = deque(maxlen=frames)

    def update(self, target: Target, stamp: float, noise: Array) -> Target:
        """Take in the target of one frame and return the mean over those that agree with it.

        Args:
            target: Newest target.
            stamp: Time of its picture [s].
            noise: Covariance of its position without systematic parts [m^2], shape (3, 3).
        """
        if self._kept and not 0.0 <= stamp - self._kept[-1][0] <= _AGE:
            self._kept.clear()
        self._kept.append((stamp, target))
        normal = -target.T_base_target[:3, 2]
        limit = _AGREE * np.sqrt(2.0 * max(float(normal @ noise @ normal), 1e-10))
        same = [
            kept for time, kept in self._kept
            if stamp - time <= _AGE
            and np.hypot(*np.subtract(kept.pixel, target.pixel)) <= _PIXELS
            and abs(normal @ (kept.T_base_target[:3, 3] - target.T_base_target[:3, 3])) <= limit
        ]  # fmt: skip
        return _mean(target, same)


def _mean(newest: Target, targets: list[Target]) -> Target:
    if len(targets) == 1:
        return newest
    poses = np.stack([target.T_base_target for target in targets])
    normal = -poses[:, :3, 2].mean(axis=0)
    pose = pose_from_normal(poses[:, :3, 3].mean(axis=0), normal / np.linalg.norm(normal))
    share = _FROZEN + (1.0 - _FROZEN) / len(targets)
    u, v = np.mean([target.pixel for target in targets], axis=0)
    return newest._replace(
        T_base_target=transform_from(pose[:3, :3], pose[:3, 3]),
        covariance=newest.covariance * share,
        pixel=(float(u), float(v)),
    )
