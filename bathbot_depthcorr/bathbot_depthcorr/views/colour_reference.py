"""The colour camera is the ruler of the calibration: its focal length, checked and refined on the board.

A focal length wrong by 0.15 % makes every depth wrong by 1 mm at 0.75 m, whatever the depth model. The
views that calibrate depth also measure the colour camera, so both are used: the factory's numbers as a
prior (0.15 %, 1 px), the corners as data. Boards become walls whose plane is known, a `ViewSet` with all
that a fit needs.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.views.chessboard import (
    LEAST_CORNER_NOISE,
    Chessboard,
    board_plane,
    board_pose,
    project,
)
from bathbot_depthcorr.views.views import CalibrationView

Array = NDArray[np.float64]

FACTORY_FOCAL = 0.0015  # relative standard deviation of the factory's focal length
FACTORY_CENTRE = 1.0  # [px]
_WEAK = 100.0  # prior of the check is so many times weaker than the factory's


class BoardView(NamedTuple):
    """One still pose: the board in colour, the wall in depth.

    Attributes:
        corners: Inner corners in the colour image [px], shape (N, 2).
        depth: Mean raw depth [m], shape (H, W), NaN = none.
        frames: Depth frames in the mean.
        temporal_noise: Standard deviation of inverse depth between frames [1/m].
    """

    corners: Array
    depth: NDArray[np.float32]
    frames: int = 1
    temporal_noise: float = 0.0


class ColourReference(NamedTuple):
    """What the board says about the colour camera.

    Attributes:
        camera: Intrinsics from board and factory together.
        focal_change: Focal length from the board alone against the factory's, relative.
        focal_sigma: Standard deviation of `focal_change`.
        corner_noise: RMS distance of corners from the fitted board [px].
        poses: Of the board in the colour frame, shape (views, 6).
    """

    camera: Pinhole
    focal_change: float
    focal_sigma: float
    corner_noise: float
    poses: Array


class ViewSet(NamedTuple):
    """Views for one calibration.

    Attributes:
        views: Walls seen by the camera.
        unit: The camera, with the factory's depth -> colour transform.
        reference: What the board says about the colour camera; None where the planes came otherwise.
        notes: What was left out on reading, one line each.
    """

    views: list[CalibrationView]
    unit: CameraUnit
    reference: ColourReference | None = None
    notes: tuple[str, ...] = ()


def measure_colour_camera(corners: Sequence[Array], board: Chessboard, factory: Pinhole) -> ColourReference:
    """Fit intrinsics and board poses to the corners of all views.

    Args:
        corners: Of each view [px], shape (N, 2).
        board: The board.
        factory: Intrinsics the camera reports.

    Raises:
        BoardNotFoundError: If the corners of a view fit no pose.
    """
    free, free_sigma, _, noise = _refine(corners, board, factory, _WEAK, LEAST_CORNER_NOISE)
    noise = max(noise, LEAST_CORNER_NOISE)
    camera, _, poses, _ = _refine(corners, board, factory, 1.0, noise)
    change = 0.5 * (free.fx / factory.fx + free.fy / factory.fy) - 1.0
    return ColourReference(camera, change, free_sigma * noise / LEAST_CORNER_NOISE / factory.fx, noise, poses)


def views_from_boards(
    boards: Sequence[BoardView], board: Chessboard, factory: Pinhole
) -> tuple[list[CalibrationView], ColourReference]:
    """Turn seen boards into walls whose true plane is known.

    Args:
        boards: Still poses.
        board: The board.
        factory: Intrinsics of the colour camera as it reports them.

    Returns:
        The views, and what was found about the colour camera.
    """
    reference = measure_colour_camera([seen.corners for seen in boards], board, factory)
    views = []
    for seen, pose in zip(boards, reference.poses, strict=True):
        plane, covariance = board_plane(pose, board, reference.camera, reference.corner_noise)
        views.append(CalibrationView(seen.depth, plane, covariance, seen.frames, seen.temporal_noise))
    return views, reference


def _refine(
    corners: Sequence[Array], board: Chessboard, factory: Pinhole, weak: float, noise: float
) -> tuple[Pinhole, float, Array, float]:
    """Gauss-Newton over intrinsics and poses; gives camera, sigma of fx [px], poses and RMS residual [px]."""
    start = np.array([factory.fx, factory.fy, factory.cx, factory.cy])
    sigma = weak * np.array(
        [FACTORY_FOCAL * factory.fx, FACTORY_FOCAL * factory.fy, FACTORY_CENTRE, FACTORY_CENTRE]
    )
    prior = np.diag((noise / sigma) ** 2)
    camera, poses = factory, [board_pose(seen, board, factory)[0] for seen in corners]
    for _ in range(12):
        intrinsics = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
        hessian, gradient, solutions, squares = prior.copy(), prior @ (intrinsics - start), [], 0.0
        for seen, pose in zip(corners, poses, strict=True):
            pixels, jacobian = project(pose, board, camera)
            residual = (pixels - seen).ravel()
            by_pose, by_camera = jacobian[:, :6], jacobian[:, 6:]
            solved = np.linalg.lstsq(by_pose, np.column_stack([by_camera, residual]), rcond=None)[0]
            rest = by_camera - by_pose @ solved[:, :-1]
            hessian += rest.T @ by_camera
            gradient += rest.T @ residual
            solutions.append(solved)
            squares += float(residual @ residual)
        step = -np.linalg.solve(hessian, gradient)
        poses = [
            pose - solved[:, -1] - solved[:, :-1] @ step
            for pose, solved in zip(poses, solutions, strict=True)
        ]
        fx, fy, cx, cy = intrinsics + step
        camera = replace(camera, fx=float(fx), fy=float(fy), cx=float(cx), cy=float(cy))
        if np.abs(step).max() < 1e-4:
            break
    count = sum(seen.size for seen in corners)
    spread = float(np.sqrt(np.linalg.inv(hessian)[0, 0])) * noise
    return camera, spread, np.array(poses), float(np.sqrt(squares / count))
