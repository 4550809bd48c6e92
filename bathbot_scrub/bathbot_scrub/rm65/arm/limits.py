"""What the joints of the RM65 may do: data sheet, but for gentler accelerations; and the home posture.

The controller's default acceleration is 600 deg/s^2; a person sits in reach, so ours is far lower, and the
jerk is chosen to reach it in 0.1 s.
"""

import numpy as np

from bathbot_scrub.arm.joint_limits import JointLimits

RM65_LIMITS = JointLimits(
    lower=np.radians([-178.0, -130.0, -135.0, -178.0, -128.0, -360.0]),
    upper=np.radians([178.0, 130.0, 135.0, 178.0, 128.0, 360.0]),
    speed=np.radians([180.0, 180.0, 225.0, 225.0, 225.0, 225.0]),
    acceleration=np.radians([200.0] * 6),
    jerk=np.radians([2000.0] * 6),
)
HOME_DEG = (0.0, 60.0, -130.0, 0.0, -80.0, 0.0)
"""Folded posture out of the camera's view [deg]."""
