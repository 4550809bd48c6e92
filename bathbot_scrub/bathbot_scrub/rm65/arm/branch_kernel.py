"""The closed form of one wrist pose, compiled: eight branches per pose, and whether a pose is one at all.

Compiled once per machine and kept beside the sources (or in NUMBA_CACHE_DIR): about 1 s the first time,
some 50 ms to load afterwards. The planner does either when it is made, before anything moves.

With c, s for cosine and sine, frame 4 at q4 = 0 has, in the base frame, the axes

    x = (-c23 c1, -c23 s1, -s23),  y = (s1, -c1, 0),  z = (-s23 c1, -s23 s1, c23), z along the forearm,

and the rotation that is left for the wrist is [x y z]^T R = Rz(q4) Ry(q5) Rz(q6).
"""

from math import acos, atan2, cos, hypot, pi, sin, sqrt

import numpy as np
from numba import njit

_REACH_SLACK = 1e-9  # of the elbow's cosine: a straight arm is reachable up to rounding
_SINGULAR = 1e-9  # sine of q5 below which q4 and q6 turn about one axis
_RIGID = 1e-6  # by which the products of a rotation's columns may miss 0 or 1


@njit(cache=True, nogil=True)
def fill_branches(poses, base, upper_arm, forearm, flange, lower, upper, out):
    """Joint angles [rad] in (-pi, pi] of all branches, NaN where out of reach or outside the limits.

    Args:
        poses: T_base_flange, shape (N, 4, 4).
        base: Height of the shoulder [m].
        upper_arm: Shoulder to elbow [m].
        forearm: Elbow to wrist centre [m].
        flange: Wrist centre to flange [m].
        lower: Limits [rad], shape (6,), may be infinite.
        upper: Likewise.
        out: Taken for the result, shape (N, 8, 6); branch 4 * shoulder + 2 * elbow + wrist.
    """
    for index in range(len(poses)):
        pose = poses[index]
        x, y = pose[0, 3] - flange * pose[0, 2], pose[1, 3] - flange * pose[1, 2]
        height = pose[2, 3] - flange * pose[2, 2] - base
        rho = hypot(x, y)
        cosine = rho * rho + height * height - upper_arm * upper_arm - forearm * forearm
        cosine /= 2.0 * upper_arm * forearm
        if not abs(cosine) <= 1.0 + _REACH_SLACK:
            out[index] = np.nan
            continue
        elbow = acos(min(max(cosine, -1.0), 1.0))
        bow = atan2(forearm * sin(elbow), upper_arm + forearm * cos(elbow))
        for shoulder in range(2):
            # positive q2 and q3 lean the arm towards -x of frame 1, hence the signs
            forward = 1.0 - 2.0 * shoulder
            q1, lean = atan2(forward * y, forward * x), atan2(-forward * rho, height)
            for bend in range(2):
                sign = 2.0 * bend - 1.0
                q2, q3 = lean - sign * bow, sign * elbow
                _fill_wrist(pose, q1, q2, q3, out[index, 4 * shoulder + 2 * bend :])
        for branch in range(8):
            for joint in range(6):
                angle = _wrapped(out[index, branch, joint])
                out[index, branch, joint] = angle
                if not lower[joint] <= angle <= upper[joint]:
                    out[index, branch] = np.nan
                    break


@njit(cache=True, nogil=True, inline="always")
def _fill_wrist(pose, q1, q2, q3, out):
    """The two wrist branches `out[:2]`, shape (2, 6), for given q1, q2, q3 [rad]."""
    c1, s1, c23, s23 = cos(q1), sin(q1), cos(q2 + q3), sin(q2 + q3)
    forward_x = c1 * pose[0, 0] + s1 * pose[1, 0]
    forward_y = c1 * pose[0, 1] + s1 * pose[1, 1]
    forward_z = c1 * pose[0, 2] + s1 * pose[1, 2]
    xx, xy = -c23 * forward_x - s23 * pose[2, 0], -c23 * forward_y - s23 * pose[2, 1]
    xz = -c23 * forward_z - s23 * pose[2, 2]
    yx, yy = s1 * pose[0, 0] - c1 * pose[1, 0], s1 * pose[0, 1] - c1 * pose[1, 1]
    yz = s1 * pose[0, 2] - c1 * pose[1, 2]
    zz = -s23 * forward_z + c23 * pose[2, 2]
    sine = sqrt(xz * xz + yz * yz)
    c4, s4 = (1.0, 0.0) if sine < _SINGULAR else (xz / sine, yz / sine)
    q4, q5 = atan2(s4, c4), atan2(sine, zz)
    # from what q4 leaves, so that an inexact q4 near the singularity costs no accuracy of the pose
    q6 = atan2(c4 * yx - s4 * xx, c4 * yy - s4 * xy)
    for wrist in range(2):
        out[wrist, 0], out[wrist, 1], out[wrist, 2] = q1, q2, q3
    out[0, 3], out[0, 4], out[0, 5] = q4, q5, q6
    if sine < _SINGULAR:  # no second branch to speak of
        out[1, 3], out[1, 4], out[1, 5] = q4, -q5, q6
    else:
        out[1, 3], out[1, 4], out[1, 5] = q4 + pi, -q5, q6 + pi


@njit(cache=True, nogil=True, inline="always")
def _wrapped(angle):
    """An angle [rad] from (-3 pi, 3 pi], in (-pi, pi]."""
    if angle > pi:
        return angle - 2.0 * pi
    return angle + 2.0 * pi if angle <= -pi else angle


@njit(cache=True, nogil=True)
def first_flawed(poses):
    """Index of the first of poses, shape (N, 4, 4), that is not finite or not a rigid transform; -1: none."""
    for index in range(len(poses)):
        pose = poses[index]
        total = 0.0
        for row in range(4):
            for column in range(4):
                total += pose[row, column]
        if not np.isfinite(total):
            return index
        for row in range(3):
            for other in range(row, 3):
                product = 0.0
                for column in range(3):
                    product += pose[row, column] * pose[other, column]
                if not abs(product - (row == other)) < _RIGID:
                    return index
        determinant = (
            pose[0, 0] * (pose[1, 1] * pose[2, 2] - pose[1, 2] * pose[2, 1])
            - pose[0, 1] * (pose[1, 0] * pose[2, 2] - pose[1, 2] * pose[2, 0])
            + pose[0, 2] * (pose[1, 0] * pose[2, 1] - pose[1, 1] * pose[2, 0])
        )
        if not determinant > 0.0:
            return index
    return -1
