"""Find the ArUco marker of the hand-eye calibration in a picture (section 2.1.4: ID 582, 100 mm)."""

from typing import NamedTuple

import cv2
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import rotation_angle, transform_from
from numpy.typing import NDArray

from bathbot_localize.errors import LocalizeError
from bathbot_localize.hand_eye.marker_edges import refine_corners

Array = NDArray[np.float64]
MARKER_ID, MARKER_SIZE = 582, 0.10  # of the paper; [m]
_OTHER = 0.02  # [rad] by which two explanations differ at least
DICTIONARY = cv2.aruco.DICT_ARUCO_ORIGINAL


class MarkerNotFoundError(LocalizeError):
    """A picture without the marker."""


class MarkerPose(NamedTuple):
    """A possible pose of the marker: T_camera_marker, shape (4, 4), and its reprojection error [px]."""

    T_camera_marker: Array
    residual_px: float


def marker_corners(size: float) -> Array:
    """Corners of a marker of edge `size` [m], shape (4, 3), z out of the print; in OpenCV's order."""
    half = size / 2.0
    return np.array([[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]])


def find_marker(grey: NDArray[np.uint8], camera: Pinhole, marker_id: int = MARKER_ID) -> Array:
    """Find the corners of the marker in a picture.

    Args:
        grey: Picture, shape (H, W).
        camera: Its intrinsics with distortion.
        marker_id: Number in the dictionary.

    Returns:
        Corners (u, v) [px], shape (4, 2), clockwise from the marker's upper left.

    Raises:
        MarkerNotFoundError: When it is not in the picture, or more than once.
    """
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(DICTIONARY))
    corners, ids, _ = detector.detectMarkers(grey)
    numbers = [] if ids is None else ids.ravel().tolist()
    found = [quad for quad, number in zip(corners, numbers, strict=True) if number == marker_id]
    if len(found) != 1:
        others = ", ".join(str(number) for number in sorted(set(numbers))) or "none"
        raise MarkerNotFoundError(
            f"marker {marker_id} is {len(found)} times in the picture; markers in it: {others}"
        )
    return refine_corners(grey, found[0].reshape(4, 2).astype(np.float64), camera)


def marker_poses(corners: Array, camera: Pinhole, size: float) -> list[MarkerPose]:
    """One or two poses that explain the corners of a marker, the better one first.

    A small or distant square seen nearly from the front has two explanations, tilted either way. The
    closed form (IPPE) finds both, but fails for a square seen exactly from the front; the iterative
    solution finds one of them always.
    """
    model, seen = marker_corners(size), corners.reshape(4, 1, 2)
    candidates = []
    for method in (cv2.SOLVEPNP_IPPE_SQUARE, cv2.SOLVEPNP_ITERATIVE):
        _, rotations, translations, residuals = cv2.solvePnPGeneric(
            model, seen, camera.matrix, camera.coefficients, flags=method
        )
        candidates += [
            MarkerPose(transform_from(cv2.Rodrigues(turn)[0], shift.ravel()), float(residual.item()))
            for turn, shift, residual in zip(rotations, translations, residuals, strict=True)
        ]
    best, *others = sorted(candidates, key=lambda pose: pose.residual_px)
    tilted = [
        pose for pose in others
        if rotation_angle(best.T_camera_marker[:3, :3].T @ pose.T_camera_marker[:3, :3]) > _OTHER
    ]  # fmt: skip
    return [best, *tilted[:1]]
