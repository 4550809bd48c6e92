"""The chessboard on the wall: its corners in a colour image and the plane they lie in."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.errors import DepthcorrError, SettingsError
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import Plane, plane_from_inverse_form

Array = NDArray[np.float64]

LEAST_CORNER_NOISE = 0.05  # [px]
_SEARCH = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE


class BoardNotFoundError(DepthcorrError):
    """An image without the whole chessboard."""


@dataclass(frozen=True, slots=True)
class Chessboard:
    """A printed chessboard: inner corners along and across, edge of a square [m]."""

    columns: int = 11
    rows: int = 8
    square: float = 0.05

    def __post_init__(self) -> None:
        """Refuse boards that cannot be found or measured."""
        if min(self.columns, self.rows) < 3:
            raise SettingsError(
                f"board must have at least 3x3 inner corners, got {self.columns}x{self.rows}; "
                "count where four squares meet"
            )
        if not 0.005 <= self.square <= 0.5:
            raise SettingsError(f"square must be 0.005 to 0.5 m, got {self.square}; give its edge in metres")

    @property
    def corners(self) -> Array:
        """Inner corners in the board's frame [m], shape (columns rows, 3), row by row, z = 0."""
        grid = np.mgrid[: self.columns, : self.rows].T.reshape(-1, 2) * self.square
        return np.column_stack([grid, np.zeros(len(grid))])


def find_corners(grey: NDArray, board: Chessboard) -> Array:
    """Find a board's inner corners [px], shape (N, 2), row by row.

    The sector-based detector alone is biased by 0.05 to 0.15 px on small squares, which makes the focal
    length 0.2 % too large; its corners are refined on the gradients.

    Args:
        grey: Brightness, uint8, shape (H, W), best the mean of the still frames.
        board: What to look for.

    Raises:
        BoardNotFoundError: If the board is absent, cut off or hidden in part.
    """
    grey = np.ascontiguousarray(grey, dtype=np.uint8)
    found, corners = cv2.findChessboardCornersSB(grey, (board.columns, board.rows), flags=_SEARCH)
    if not found:
        raise BoardNotFoundError(
            f"no chessboard of {board.columns}x{board.rows} inner corners in the image; "
            "is all of it visible and lit?"
        )
    grid = corners.reshape(board.rows, board.columns, 2)
    pitch = min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))
    half = int(np.clip(0.35 * pitch, 2, 5))
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-3)
    return cv2.cornerSubPix(grey, corners, (half, half), (-1, -1), criteria).reshape(-1, 2).astype(float)


def board_pose(corners: Array, board: Chessboard, camera: Pinhole) -> tuple[Array, Array]:
    """Rotation vector [rad] and translation [m] of the board, shape (6,); and the RMS residual [px].

    Raises:
        BoardNotFoundError: If no pose explains the corners.
    """
    arguments = (board.corners, corners, camera.matrix, camera.coefficients)
    found, rotation, translation = cv2.solvePnP(*arguments, flags=cv2.SOLVEPNP_IPPE)
    if not found or not np.isfinite(translation).all() or translation[2] <= 0.0:
        raise BoardNotFoundError(
            "no pose of the board explains its corners; are columns and rows as printed?"
        )
    rotation, translation = cv2.solvePnPRefineLM(*arguments, rotation, translation)
    pose = np.concatenate([rotation.ravel(), translation.ravel()])
    left = project(pose, board, camera)[0] - corners
    return pose, float(np.sqrt(np.mean(np.square(left))))


def project(pose: Array, board: Chessboard, camera: Pinhole) -> tuple[Array, Array]:
    """Corners [px], shape (N, 2), and derivatives, shape (2 N, 10), by pose (6), fx, fy, cx, cy."""
    pixels, jacobian = cv2.projectPoints(
        board.corners, pose[:3], pose[3:], camera.matrix, camera.coefficients
    )
    return pixels.reshape(-1, 2), jacobian[:, :10]


def inverse_form(pose: Array) -> Array:
    """Vector m of the board's plane m.x = 1 in the camera frame [1/m], shape (3,)."""
    normal = cv2.Rodrigues(pose[:3])[0][:, 2]
    return normal / float(normal @ pose[3:])


def board_plane(pose: Array, board: Chessboard, camera: Pinhole, noise: float) -> tuple[Plane, Array]:
    """The wall's plane in the colour frame and the covariance of its inverse form [1/m^2], shape (3, 3).

    Args:
        pose: Of the board, shape (6,).
        board: The board.
        camera: Intrinsics of the colour camera.
        noise: Standard deviation of the corners [px].
    """
    jacobian = project(pose, board, camera)[1][:, :6]
    covariance = np.linalg.inv(jacobian.T @ jacobian) * max(noise, LEAST_CORNER_NOISE) ** 2
    steps = np.eye(6) * 1e-6
    by_pose = np.stack(
        [(inverse_form(pose + step) - inverse_form(pose - step)) / 2e-6 for step in steps], axis=1
    )
    return plane_from_inverse_form(inverse_form(pose)), by_pose @ covariance @ by_pose.T
