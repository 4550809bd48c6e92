"""A marker on an arm before a camera beside it, for tests."""

import cv2
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, transform_from, transform_points
from bathbot_localize.hand_eye.marker import DICTIONARY, MARKER_ID, MARKER_SIZE, marker_corners
from bathbot_localize.hand_eye.solver import MarkerView
from localize_scene import T_BASE_COLOUR as T_BASE_CAMERA
from scipy.spatial.transform import Rotation

CAMERA = Pinhole(640, 400, 318.0, 317.6, 320.4, 199.1, (-0.0565, 0.0688, -0.00072, -0.00002, -0.0224))
T_TOOL_MARKER = transform_from(Rotation.from_rotvec([0.1, -0.05, 0.4]).as_matrix(), (0.01, -0.02, 0.03))


def arm_poses(count, rng):
    """T_base_tool with the marker 0.45 to 0.65 m before the camera, tilted up to 35 degrees."""
    poses = []
    for _ in range(count):
        tilt = Rotation.from_rotvec(rng.uniform(-0.6, 0.6, 3)).as_matrix()
        facing = np.diag([1.0, -1.0, -1.0])
        depth = rng.uniform(0.45, 0.65)
        place = (rng.uniform(-0.25, 0.25) * depth, rng.uniform(-0.2, 0.2) * depth, depth)
        T_camera_marker = transform_from(tilt @ facing, place)
        poses.append(T_BASE_CAMERA @ T_camera_marker @ inverse(T_TOOL_MARKER))
    return poses


def marker_view(T_base_tool, rng, noise=0.0):
    T_camera_marker = inverse(T_BASE_CAMERA) @ T_base_tool @ T_TOOL_MARKER
    corners = CAMERA.project(transform_points(T_camera_marker, marker_corners(MARKER_SIZE)))
    return MarkerView(T_base_tool, corners + rng.normal(0.0, noise, corners.shape))


def draw_marker(T_base_tool, rng, marker_id=MARKER_ID, noise=2.0):
    """A grey picture of the marker on a white board, three by three rays to the pixel."""
    cells = 40
    print_ = cv2.aruco.generateImageMarker(
        cv2.aruco.getPredefinedDictionary(DICTIONARY), marker_id, 7 * cells
    )
    light = np.where(print_ > 127, 0.8, 0.04).astype(np.float32)
    sheet = cv2.copyMakeBorder(
        light, 2 * cells, 2 * cells, 2 * cells, 2 * cells, cv2.BORDER_CONSTANT, value=0.8
    )
    T_marker_camera = inverse(inverse(T_BASE_CAMERA) @ T_base_tool @ T_TOOL_MARKER)
    picture = np.zeros((CAMERA.height, CAMERA.width))
    offsets = (-1.0 / 3.0, 0.0, 1.0 / 3.0)
    for du in offsets:
        for dv in offsets:
            rays = _rays(du, dv) @ T_marker_camera[:3, :3].T
            share = -T_marker_camera[2, 3] / rays[..., 2]
            x = T_marker_camera[0, 3] + share * rays[..., 0]
            y = T_marker_camera[1, 3] + share * rays[..., 1]
            scale = 7 * cells / MARKER_SIZE
            column = (x * scale + 5.5 * cells - 0.5).astype(np.float32)
            row = (-y * scale + 5.5 * cells - 0.5).astype(np.float32)
            picture += cv2.remap(
                sheet, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0.3
            )
    # Light is averaged over a pixel; a camera writes it down with a gamma.
    picture = 255.0 * (picture / 9.0) ** (1.0 / 2.2) + rng.normal(0.0, noise, picture.shape)
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


_CACHE = {}


def _rays(du, dv):
    if (du, dv) not in _CACHE:
        _CACHE[du, dv] = CAMERA.directions(CAMERA.pixel_grid() + np.array([du, dv]))
    return _CACHE[du, dv]
