"""What a calibration must meet before it is believed; each refusal names the number that failed.

The map is not the limit of absolute accuracy, its references are: the colour camera's focal length, the
size of the printed squares, and views that differ enough to tell errors apart.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from bathbot_depthcorr.calibration.coverage import SAME_ANGLE, SAME_DISTANCE, coverage_of, pose_of
from bathbot_depthcorr.errors import DepthcorrError
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.rigid import inverse
from bathbot_depthcorr.views.colour_reference import ColourReference
from bathbot_depthcorr.views.views import CalibrationView

Array = NDArray[np.float64]

GOOD_VIEWS = 18
LEAST_TILT = np.deg2rad(8.0)
LEAST_SPAN = 1.3  # farthest over nearest
MOST_FOCAL = 0.005  # relative change of focal length against the factory
MOST_CORNER_NOISE = 1.0  # [px]
MOST_TURN, ODD_TURN = np.deg2rad(1.5), np.deg2rad(0.5)  # of the extrinsics against the factory
MOST_MOVE, ODD_MOVE = 0.015, 0.004  # [m]
MOST_PARALLAX, ODD_PARALLAX = 0.05, 0.025  # relative change of the distance between the imagers
LEAST_PARALLAX = 0.02  # [m] from which on that distance tells anything


class CalibrationRefusedError(DepthcorrError):
    """Views from which no trustworthy correction can be made."""


class Demands(NamedTuple):
    """What views must bring.

    Attributes:
        views: Least number.
        distinct: Least number of those that differ.
        tilted: Least share of those that are tilted.
    """

    views: int
    distinct: int
    tilted: float


BOARD_DEMANDS = Demands(10, 8, 1.0 / 3.0)
KNOWN_DEMANDS = Demands(5, 4, 0.0)  # no board must tell the focal length


def demands_on(views: Sequence[CalibrationView]) -> Demands:
    """What views must bring: less where their planes are exact, as in public data sets."""
    exact = all(not np.any(view.covariance) for view in views)
    return KNOWN_DEMANDS if exact and views else BOARD_DEMANDS


def check_views(views: Sequence[CalibrationView]) -> list[str]:
    """Check number, variety, tilt and distances of the views.

    Returns:
        Warnings, one line each.

    Raises:
        CalibrationRefusedError: Naming the number that failed.
    """
    demands = demands_on(views)
    if len(views) < demands.views:
        raise CalibrationRefusedError(
            f"{len(views)} usable views of the wall, at least {demands.views} are needed; "
            "record 18 or more still poses of a second each"
        )
    distinct = _count_distinct(views)
    if distinct < demands.distinct:
        raise CalibrationRefusedError(
            f"only {distinct} of {len(views)} views differ by more than {SAME_DISTANCE * 100:.0f} cm or "
            f"{np.rad2deg(SAME_ANGLE):.0f} deg, at least {demands.distinct} are needed; "
            "move the camera between views"
        )
    tilted = float(np.mean([view.tilt >= LEAST_TILT for view in views]))
    told = f"{tilted:.0%} of the views are tilted by {np.rad2deg(LEAST_TILT):.0f} deg or more"
    if tilted < demands.tilted:
        raise CalibrationRefusedError(
            f"{told}, at least {demands.tilted:.0%} are needed; turn the camera 15 to 25 deg to all sides"
        )
    distances = [view.distance for view in views]
    span = max(distances) / min(distances)
    if span < LEAST_SPAN:
        raise CalibrationRefusedError(
            f"distances span {min(distances):.2f} to {max(distances):.2f} m, the farthest must be "
            f"{LEAST_SPAN} times the nearest; record from 0.5 to 1.5 m"
        )
    warnings = []
    if tilted < BOARD_DEMANDS.tilted:
        warnings.append(f"{told}: the depth -> colour transform is hardly more than the given one")
    if len(views) < GOOD_VIEWS:
        warnings.append(f"{len(views)} views; {GOOD_VIEWS} or more halve the error")
    if min(distances) > 0.65 or max(distances) < 0.9:
        warnings.append(
            f"views from {min(distances):.2f} to {max(distances):.2f} m do not enclose 0.65 to 0.9 m"
        )
    return warnings


def check_colour(reference: ColourReference) -> list[str]:
    """Compare the colour camera's focal length with the factory's; warnings as in `check_views`.

    Raises:
        CalibrationRefusedError: If they differ by more than 0.5 %, or the corners do not fit a board.
    """
    if reference.corner_noise > MOST_CORNER_NOISE:
        raise CalibrationRefusedError(
            f"corners miss the fitted board by {reference.corner_noise:.2f} px RMS, at most "
            f"{MOST_CORNER_NOISE} is allowed; is the board flat, and did the camera stand still?"
        )
    excess = abs(reference.focal_change) - 2.0 * reference.focal_sigma
    if excess > MOST_FOCAL:
        raise CalibrationRefusedError(
            f"focal length from the board differs by {reference.focal_change:+.2%} from the factory's, "
            f"at most {MOST_FOCAL:.1%} is allowed; tilt the camera more, and check camera_info"
        )
    if reference.focal_sigma > MOST_FOCAL:
        return [f"the views fix the focal length to {reference.focal_sigma:.2%} only; the factory's was kept"]
    return []


def check_coverage(views: Sequence[CalibrationView], unit: CameraUnit) -> list[str]:
    """Name distances, tilts and corners of the picture of which the views hold little; never refuses."""
    coverage = coverage_of(pose_of(view, unit) for view in views)
    if not coverage.missing:
        return []
    thin = ", ".join(
        f"{goal} {coverage.counts[goal]} of {coverage.counts[goal] + want}"
        for goal, want in coverage.missing.items()
    )
    return [f"few views of: {thin}; the correction is less sure there"]


def check_extrinsics(fitted: CameraUnit, factory: CameraUnit) -> list[str]:
    """Compare the fitted depth -> colour transform with the factory's.

    Raises:
        CalibrationRefusedError: If they differ by more than 1.5 deg or 15 mm.
    """
    change = extrinsics_change(fitted, factory)
    turn, move = float(np.linalg.norm(change[:3])), float(np.linalg.norm(change[3:]))
    told = (
        f"depth -> colour is {np.rad2deg(turn):.2f} deg and {move * 1e3:.1f} mm off the factory's transform"
    )
    if turn > MOST_TURN or move > MOST_MOVE:
        raise CalibrationRefusedError(
            f"{told}, at most 1.5 deg and 15 mm are allowed; are the topics of one camera?"
        )
    return [f"{told}; was the camera dropped?"] if turn > ODD_TURN or move > ODD_MOVE else []


def check_parallax(fitted: CameraUnit, factory: CameraUnit) -> list[str]:
    """Compare the fitted distance between the imagers, which grows with the squares, with the factory's.

    Raises:
        CalibrationRefusedError: If they differ by more than 5 %.
    """
    before, after = (float(np.linalg.norm(unit.T_colour_depth[:3, 3])) for unit in (factory, fitted))
    if before < LEAST_PARALLAX or abs(after / before - 1.0) <= ODD_PARALLAX:
        return []
    told = (
        f"depth and colour imager are {after * 1e3:.1f} mm apart by the board, {before * 1e3:.1f} mm by the "
        f"factory, {after / before - 1.0:+.1%}"
    )
    if abs(after / before - 1.0) > MOST_PARALLAX:
        raise CalibrationRefusedError(
            f"{told}, at most {MOST_PARALLAX:.0%} is allowed; measure a printed square, give it with --square"
        )
    return [f"{told}; is --square the measured edge of a square?"]


def extrinsics_change(fitted: CameraUnit, factory: CameraUnit) -> Array:
    """Turn [rad] and move [m] between two depth -> colour transforms, shape (6,)."""
    change = fitted.T_colour_depth @ inverse(factory.T_colour_depth)
    move = fitted.T_colour_depth[:3, 3] - factory.T_colour_depth[:3, 3]
    return np.concatenate([Rotation.from_matrix(change[:3, :3]).as_rotvec(), move])


def _count_distinct(views: Sequence[CalibrationView]) -> int:
    kept: list[CalibrationView] = []
    for view in views:
        same = [
            abs(view.distance - other.distance) < SAME_DISTANCE
            and float(view.plane.normal @ other.plane.normal) > np.cos(SAME_ANGLE)
            for other in kept
        ]
        if not any(same):
            kept.append(view)
    return len(kept)
