"""Corners of a marker from the straight lines of its sides.

A corner is a poor thing to find: blur rounds it, and a corner detector then puts it too far inside.
Along the four sides of the black square there are many points instead. Each is the middle of the
step from black to white across the side, in linear light, because a camera's gamma moves the middle
of a blurred step by a tenth of a pixel. Lines are fitted where the lens bends nothing, on rays.
"""

import cv2
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from numpy.typing import NDArray

Array = NDArray[np.float64]
_SAMPLES = 48  # along a side
_ENDS = 0.08  # share of a side left out at both ends, where corners are round
_REACH = 0.45  # how far across the side is looked, in cells of the marker: less than its black border
_CELLS = 7  # cells of a side
_STEP = 0.25  # [px] across the side
_GAMMA = 2.2
_ROUNDS = 2  # the second one looks across the sides that the first one found


def refine_corners(grey: NDArray[np.uint8], corners: Array, camera: Pinhole) -> Array:
    """Corners (u, v) [px], shape (4, 2), where the sides of a black square on white meet.

    Args:
        grey: Picture, shape (H, W).
        corners: Corners to start from [px], shape (4, 2), clockwise as seen, within two pixels.
        camera: Intrinsics with distortion.
    """
    light = (grey.astype(np.float32) / np.float32(255.0)) ** np.float32(_GAMMA)
    for _ in range(_ROUNDS):
        sides = [_side(light, corners[i], corners[(i + 1) % 4], camera) for i in range(4)]
        meets = np.stack([np.cross(sides[i - 1], sides[i]) for i in range(4)])
        corners = camera.project(meets / meets[:, 2:])
    return corners


def _side(light: NDArray[np.float32], start: Array, end: Array, camera: Pinhole) -> Array:
    """Line l with l.(x, y, 1) = 0 on the rays (x, y, 1) along one side, shape (3,)."""
    along = end - start
    length = float(np.linalg.norm(along))
    across = np.array([along[1], -along[0]]) / length  # outwards, as corners run clockwise in the picture
    reach = max(_REACH * length / _CELLS, 1.5)
    steps = np.arange(-reach, reach + _STEP, _STEP)
    base = start + np.linspace(_ENDS, 1.0 - _ENDS, _SAMPLES)[:, None] * along
    places = (base[:, None, :] + steps[None, :, None] * across).astype(np.float32)
    profile = cv2.remap(light, places[..., 0], places[..., 1], cv2.INTER_CUBIC)
    rise = np.clip(np.diff(profile, axis=1), 0.0, None)  # from black inside to white outside
    middle = (steps[:-1] + steps[1:]) / 2.0
    shift = rise @ middle / np.maximum(rise.sum(axis=1), 1e-9)
    near = np.abs(middle - shift[:, None]) <= 0.6 * reach  # once more, around the step itself
    shift = (rise * near) @ middle / np.maximum((rise * near).sum(axis=1), 1e-9)
    rays = camera.directions(base + shift[:, None] * across)[:, :2]
    tx, ty, x, y = cv2.fitLine(rays.astype(np.float32), cv2.DIST_HUBER, 0, 1e-9, 1e-9).ravel().astype(float)
    return np.array([ty, -tx, tx * y - ty * x])
