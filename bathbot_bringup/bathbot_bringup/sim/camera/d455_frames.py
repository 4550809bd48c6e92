"""The frames of a D455 as realsense2_camera names them."""

import numpy as np
from bathbot_depthcorr.geometry.rigid import inverse
from numpy.typing import NDArray

from bathbot_bringup.sim.camera.d455_unit import D455Unit
from bathbot_bringup.sim.scene import T_LINK_OPTICAL

Array = NDArray[np.float64]


def camera_frames(unit: D455Unit) -> list[tuple[str, str, Array]]:
    """Parent, child and transform (maps child to parent), by the factory's extrinsics.

    camera_link sits at the depth camera with x forward, y left, z up.
    """
    T_link_colour_optical = T_LINK_OPTICAL @ inverse(unit.published_T_colour_depth)
    return [
        ("camera_link", "camera_depth_frame", np.eye(4)),
        ("camera_depth_frame", "camera_depth_optical_frame", T_LINK_OPTICAL),
        ("camera_link", "camera_color_frame", T_link_colour_optical @ inverse(T_LINK_OPTICAL)),
        ("camera_color_frame", "camera_color_optical_frame", T_LINK_OPTICAL),
    ]
