"""Compares the wall in raw depth with the board's plane before anything is fitted to it."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.stats import theilslopes

from bathbot_depthcorr.calibration.guards import CalibrationRefusedError, demands_on
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.geometry.plane import DegeneratePlaneError, fit_plane
from bathbot_depthcorr.geometry.rigid import inverse
from bathbot_depthcorr.views.views import CalibrationView

LEAST_WALL = 0.2  # share of the depth picture
MOST_SCALE, ODD_SCALE = 0.06, 0.03  # relative difference of board and raw depth
MOST_ANGLE = np.deg2rad(8.0)  # between the wall in raw depth and the board


class WallComparison(NamedTuple):
    """Raw depth against the board's planes.

    Attributes:
        scale: Raw over true depth where disparity is large: near the camera.
        shift: Raw minus true disparity beyond that [px].
        angle: Between raw and true wall, median [rad].
    """

    scale: float
    shift: float
    angle: float


def keep_walls(views: Sequence[CalibrationView], unit: CameraUnit) -> tuple[list[CalibrationView], list[str]]:
    """Leave out views whose depth shows too little: glare, people, a blocked imager.

    Returns:
        The views left, and warnings, one line each.

    Raises:
        CalibrationRefusedError: If too few are left.
    """
    shares = [float(np.isfinite(view.depth).mean()) for view in views]
    kept = [view for view, share in zip(views, shares, strict=True) if share >= LEAST_WALL]
    if len(kept) == len(views):
        return kept, []
    told = (
        f"depth shows the wall on {LEAST_WALL:.0%} or more of the picture in only {len(kept)} of "
        f"{len(views)} views, the worst has {min(shares):.0%}"
    )
    least = demands_on(views).views
    if len(kept) < least:
        raise CalibrationRefusedError(
            f"{told}; at least {least} views are needed: is the projector on, the wall without glare, "
            "and the camera not too near?"
        )
    return kept, [f"{told}; the others were left out"]


def compare_wall(views: Sequence[CalibrationView], unit: CameraUnit) -> WallComparison:
    """Compare the raw walls with the board's planes, over all distances.

    Raw over true disparity is a straight line over the distance: it begins at the inverse of the scale and
    rises by the shift over f B.

    Raises:
        CalibrationRefusedError: If a view shows no wall.
    """
    ratios, angles = zip(*(_compare(view, unit) for view in views), strict=True)
    distances = [view.distance for view in views]
    slope, begin, *_ = theilslopes(1.0 / np.array(ratios), distances)
    return WallComparison(1.0 / float(begin), float(slope) * unit.focal_baseline, float(np.median(angles)))


def check_wall(found: WallComparison) -> list[str]:
    """Judge what `compare_wall` gave: finds a wrong square size, a mirrored image, aligned depth.

    The scale of raw depth itself errs by 2 %, so a square wrong by less than 3 % cannot be told from it.

    Raises:
        CalibrationRefusedError: If scale or direction of the wall cannot be right.
    """
    if not abs(found.scale - 1.0) <= MOST_SCALE:
        raise CalibrationRefusedError(
            f"raw depth is {found.scale:.3f} times the board's distance, beyond {MOST_SCALE:.0%}; "
            "measure a printed square and give its edge with --square"
        )
    if found.angle > MOST_ANGLE:
        raise CalibrationRefusedError(
            f"the wall in depth is turned by {np.rad2deg(found.angle):.1f} deg against the board, at most "
            f"{np.rad2deg(MOST_ANGLE):.0f} are allowed; is the image mirrored, or the board not on the wall?"
        )
    if abs(found.scale - 1.0) > ODD_SCALE:
        return [
            f"raw depth is {found.scale:.3f} times the board's distance: more than a D455 errs; "
            "measure the squares"
        ]
    return []


def _compare(view: CalibrationView, unit: CameraUnit) -> tuple[float, float]:
    """Distance of the raw wall over the board's, and the angle [rad] between them."""
    every = (slice(4, None, 8), slice(4, None, 8))
    rays = unit.depth_camera.directions(unit.depth_camera.pixel_grid()[every])
    expected = view.plane.transformed(inverse(unit.T_colour_depth))
    try:
        found = fit_plane(rays * view.depth[every][..., None], robust=True)
    except DegeneratePlaneError as error:
        raise CalibrationRefusedError(
            f"a view at {view.distance:.2f} m shows no wall in depth: {error}"
        ) from error
    angle = float(np.arccos(np.clip(found.normal @ expected.normal, -1.0, 1.0)))
    axis = np.array([0.0, 0.0, 1.0])
    return float(found.depth_along(axis) / expected.depth_along(axis)), angle
