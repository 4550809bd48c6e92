"""Link frames of the RM65-6F for tests, straight from its modified DH table, and its shape."""

import numpy as np
from bathbot_depthcorr.geometry.rigid import transform_from
from bathbot_localize.arm.arm_shape import installed_shape
from scipy.spatial.transform import Rotation

SHAPE = installed_shape()
# alpha(i-1) [deg], a(i-1) [m], d [m], offset [deg]
TABLE = (
    (0, 0, 0.2405, 0),
    (90, 0, 0, 90),
    (0, 0.256, 0, 90),
    (90, 0, 0.210, 0),
    (-90, 0, 0, 0),
    (90, 0, 0.1725, 0),
)


def links_of(q):
    """T_base_link of base_link, Link1..Link6 and scrub_head at joint angles [rad]."""
    links, pose = {"base_link": np.eye(4)}, np.eye(4)
    for index, ((alpha, a, d, offset), angle) in enumerate(zip(TABLE, q, strict=True), start=1):
        pose = pose @ transform_from(Rotation.from_euler("x", alpha, degrees=True).as_matrix(), (a, 0.0, 0.0))
        pose = pose @ transform_from(
            Rotation.from_euler("z", angle + np.radians(offset)).as_matrix(), (0.0, 0.0, d)
        )
        links[f"Link{index}"] = pose
    links["scrub_head"] = pose @ transform_from(translation=(0.0, 0.0, 0.10))
    return links
