"""Eye-to-hand calibration (section 2.1.4): the camera stands beside the arm, the marker rides on it.

    T_base_camera T_camera_marker = T_base_tool T_tool_marker        for every arm pose

Closed forms (Tsai, Park, Horaud, Andreff, Daniilidis; robot-world: Shah, Li) give first guesses. The
best one is refined: both unknown transforms together, so that the marker's corners fall where they
were seen [px], with a robust loss. Only the corners count there, not the weakly known marker poses.
"""

from typing import NamedTuple

import cv2
import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.rigid import inverse, transform_from
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from bathbot_localize.errors import LocalizeError
from bathbot_localize.hand_eye.calibration_file import HandEye
from bathbot_localize.hand_eye.marker import MARKER_SIZE, marker_corners, marker_poses

Array = NDArray[np.float64]
LEAST_POSES = 8
LEAST_SPREAD_DEG = 10.0  # rms turn about the second most turned axis
MOST_RESIDUAL_PX = 1.5
MOST_UNCERTAINTY = 0.005  # [m]
_METHODS = {
    "tsai": cv2.CALIB_HAND_EYE_TSAI, "park": cv2.CALIB_HAND_EYE_PARK, "horaud": cv2.CALIB_HAND_EYE_HORAUD,
    "andreff": cv2.CALIB_HAND_EYE_ANDREFF, "daniilidis": cv2.CALIB_HAND_EYE_DANIILIDIS,
}  # fmt: skip
_WORLD_METHODS = {"shah": cv2.CALIB_ROBOT_WORLD_HAND_EYE_SHAH, "li": cv2.CALIB_ROBOT_WORLD_HAND_EYE_LI}


class HandEyeError(LocalizeError):
    """Views of a marker that do not determine where the camera is."""


class MarkerView(NamedTuple):
    """One still arm pose: T_base_tool, shape (4, 4), and the marker's corners [px], shape (4, 2)."""

    T_base_tool: Array
    corners: Array


class HandEyeReport(NamedTuple):
    """Result of a calibration.

    Attributes:
        hand_eye: What is written to the file.
        T_tool_marker: Pose of the marker on the tool, shape (4, 4).
        methods: Reprojection error [px] of each closed form, before refinement.
        dropped: Number of views that did not agree with the others.
        position_std: Standard deviation of the camera's position, per axis [m], shape (3,).
        rotation_std: Standard deviation of its rotation [rad], shape (3,).
    """

    hand_eye: HandEye
    T_tool_marker: Array
    methods: dict[str, float]
    dropped: int
    position_std: Array
    rotation_std: Array

    def lines(self) -> list[str]:
        """The report for a person."""
        x, y, z = self.hand_eye.T_base_camera[:3, 3]
        return [
            f"camera in base_link: x {x:.4f} y {y:.4f} z {z:.4f} m",
            f"standard deviation: {1e3 * np.linalg.norm(self.position_std):.2f} mm, "
            f"{np.degrees(np.linalg.norm(self.rotation_std)):.3f} deg",
            f"residual: {self.hand_eye.residual_px:.3f} px, {self.hand_eye.residual_mm:.3f} mm at the marker",
            f"arm poses: {self.hand_eye.poses} used, {self.dropped} dropped, "
            f"turns of {self.hand_eye.rotation_spread_deg:.0f} deg about the second axis",
            "before refinement [px]: " + ", ".join(f"{name} {px:.2f}" for name, px in self.methods.items()),
        ]


def solve_hand_eye(
    views: list[MarkerView], camera: Pinhole, marker_size: float = MARKER_SIZE, date: str = ""
) -> HandEyeReport:
    """Where the camera is in the base frame.

    Args:
        views: One per still arm pose, at least 8, with turns about two axes.
        camera: Intrinsics of the colour camera.
        marker_size: Edge of the marker's black square [m].
        date: Written into the result.

    Raises:
        HandEyeError: When there are too few or too similar poses, or the result does not explain the views.
    """
    _refuse_few(len(views))
    spread = rotation_spread([view.T_base_tool for view in views])
    if spread < np.radians(LEAST_SPREAD_DEG):
        raise HandEyeError(
            f"the arm turned by {np.degrees(spread):.1f} deg about its second axis, needed are "
            f"{LEAST_SPREAD_DEG:.0f}; tilt the marker about two different axes between the poses"
        )
    guesses = closed_forms(views, camera, marker_size)
    scored = {name: rms(reprojection(*guess, views, camera, marker_size)) for name, guess in guesses.items()}
    guess = guesses[min(scored, key=scored.get)]
    fit = _refine(guess, views, camera, marker_size)
    error = np.linalg.norm(reprojection(*fit.transforms, views, camera, marker_size), axis=(1, 2)) / 2.0
    kept = [
        view for view, px in zip(views, error, strict=True) if px <= max(3.0 * float(np.median(error)), 1.0)
    ]
    _refuse_few(len(kept), len(views) - len(kept))
    if len(kept) < len(views):
        fit = _refine(fit.transforms, kept, camera, marker_size)
    return _report(fit, kept, camera, marker_size, scored, len(views) - len(kept), spread, date)


class _Fit(NamedTuple):
    transforms: tuple[Array, Array]  # T_base_camera, T_tool_marker
    covariance: Array  # (6, 6): rotation of the camera [rad], its position [m], base frame


def rotation_spread(T_base_tool: list[Array]) -> float:
    """Root mean square turn [rad] about the second most turned axis, against the mean orientation."""
    rotations = Rotation.from_matrix(np.stack(T_base_tool)[:, :3, :3])
    turns = (rotations.mean().inv() * rotations).as_rotvec()
    return float(np.linalg.svd(turns, compute_uv=False)[1] / np.sqrt(len(turns)))


def closed_forms(views: list[MarkerView], camera: Pinhole, size: float) -> dict[str, tuple[Array, Array]]:
    """First guesses (T_base_camera, T_tool_marker) by name; methods that fail on these views are left out."""
    T_base_tool = np.stack([view.T_base_tool for view in views])
    T_camera_marker = np.stack(
        [marker_poses(view.corners, camera, size)[0].T_camera_marker for view in views]
    )
    T_tool_base = inverse(T_base_tool)
    hand, eye = _parts(T_tool_base), _parts(T_camera_marker)
    found = {}
    for name, method in _METHODS.items():
        try:
            rotation, translation = cv2.calibrateHandEye(*hand, *eye, method=method)
        except cv2.error:
            continue
        found[name] = transform_from(rotation, translation.ravel())
    for name, method in _WORLD_METHODS.items():
        try:
            *_, rotation, translation = cv2.calibrateRobotWorldHandEye(
                *eye, *_parts(T_base_tool), method=method
            )
        except cv2.error:
            continue
        found[name] = inverse(transform_from(rotation, translation.ravel()))
    return {
        name: (guess, _mean_transform(T_tool_base @ guess @ T_camera_marker))
        for name, guess in found.items()
        if np.isfinite(guess).all() and abs(np.linalg.det(guess[:3, :3]) - 1.0) < 1e-3
    }


def reprojection(
    T_base_camera: Array, T_tool_marker: Array, views: list[MarkerView], camera: Pinhole, size: float
) -> Array:
    """Where the corners fall minus where they were seen [px], shape (views, 4, 2); 1e3 behind the camera."""
    corners = marker_corners(size)
    chain = inverse(T_base_camera) @ np.stack([view.T_base_tool for view in views]) @ T_tool_marker
    points = np.einsum("nij,kj->nki", chain[:, :3, :3], corners) + chain[:, None, :3, 3]
    return np.nan_to_num(camera.project(points) - np.stack([view.corners for view in views]), nan=1e3)


def rms(residuals: Array) -> float:
    """Root mean square length of residuals, shape (..., 2)."""
    return float(np.sqrt(np.square(residuals).sum(axis=-1).mean()))


def _refine(guess: tuple[Array, Array], views: list[MarkerView], camera: Pinhole, size: float) -> _Fit:
    """Least squares over both transforms, each as a small turn and shift of its guess."""

    def moved(step: Array) -> tuple[Array, Array]:
        return tuple(
            transform_from(Rotation.from_rotvec(s[:3]).as_matrix() @ start[:3, :3], start[:3, 3] + s[3:])
            for s, start in zip(step.reshape(2, 6), guess, strict=True)
        )

    def residuals(step: Array) -> Array:
        return reprojection(*moved(step), views, camera, size).ravel()

    result = least_squares(residuals, np.zeros(12), loss="soft_l1", f_scale=0.5, x_scale="jac", max_nfev=200)
    plain = residuals(result.x)
    variance = np.square(1.4826 * np.median(np.abs(plain))) * len(plain) / max(len(plain) - 12, 1)
    covariance = np.linalg.pinv(result.jac.T @ result.jac) * variance
    return _Fit(moved(result.x), covariance[:6, :6])


def _report(
    fit: _Fit, views: list[MarkerView], camera: Pinhole, size: float, methods: dict[str, float], dropped: int,
    spread: float, date: str,
) -> HandEyeReport:  # fmt: skip
    residual = rms(reprojection(*fit.transforms, views, camera, size))
    position_std = np.sqrt(np.diag(fit.covariance)[3:])
    if residual > MOST_RESIDUAL_PX:
        raise HandEyeError(
            f"the corners lie {residual:.2f} px from where the result puts them, allowed are "
            f"{MOST_RESIDUAL_PX} px; is the marker's size right, is it flat and fixed, "
            "did the arm stand still?"
        )
    if np.linalg.norm(position_std) > MOST_UNCERTAINTY:
        raise HandEyeError(
            f"the camera's position is known to {1e3 * np.linalg.norm(position_std):.1f} mm only, wanted are "
            f"{1e3 * MOST_UNCERTAINTY:.0f} mm; show the marker nearer and at more different tilts"
        )
    T_base_camera, T_tool_marker = fit.transforms
    T_camera_marker = inverse(T_base_camera) @ np.stack([view.T_base_tool for view in views]) @ T_tool_marker
    residual_mm = 1e3 * residual * float(np.mean(T_camera_marker[:, 2, 3])) / camera.fx
    hand_eye = HandEye(T_base_camera, residual, residual_mm, len(views), float(np.degrees(spread)), date)
    return HandEyeReport(
        hand_eye, T_tool_marker, methods, dropped, position_std, np.sqrt(np.diag(fit.covariance)[:3])
    )


def _refuse_few(count: int, dropped: int = 0) -> None:
    if count < LEAST_POSES:
        after = f" after {dropped} that disagree were dropped" if dropped else ""
        raise HandEyeError(
            f"{count} still arm poses show the marker{after}, needed are {LEAST_POSES}; record more, "
            "each held still for a second with the whole marker in view"
        )


def _parts(transforms: Array) -> tuple[list[Array], list[Array]]:
    """Rotations and translations, as OpenCV wants them."""
    return list(transforms[:, :3, :3]), list(transforms[:, :3, 3])


def _mean_transform(transforms: Array) -> Array:
    """Mean of the half of transforms, shape (n, 4, 4), that lies nearest to the median place."""
    away = np.linalg.norm(transforms[:, :3, 3] - np.median(transforms[:, :3, 3], axis=0), axis=1)
    near = transforms[away <= np.median(away)]
    return transform_from(
        Rotation.from_matrix(near[:, :3, :3]).mean().as_matrix(), near[:, :3, 3].mean(axis=0)
    )
