"""What a fitted correction must do, and the errors of one corrected picture against a known surface.

The errors are those of `docs/depth.md`.
"""

from typing import NamedTuple, Protocol

import numpy as np
from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import DegeneratePlaneError, fit_plane
from bathbot_depthcorr.geometry.quality import plane_rmse, z_accuracy
from numpy.typing import NDArray

Array = NDArray[np.float64]
Depth = NDArray[np.float32]

INNER = 0.8  # share of the picture's width and height that counts as its inner part
CIRCLE = 20.0  # [px of 848 columns] radius of a target point's neighbourhood
_GRID = (0.3, 0.5, 0.7)  # of width and height: where target points lie


class Fitted(Protocol):
    """A fitted correction."""

    @property
    def T_colour_depth(self) -> NDArray[np.float64]:
        """Maps points of the depth frame to the colour frame, shape (4, 4)."""
        ...

    def apply(self, depth: Depth) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        ...


def positive(depth: Depth) -> Depth:
    """Depth as float32, NaN where it is not positive."""
    return np.where(depth > 0.0, depth, np.nan).astype(np.float32)


class Errors(NamedTuple):
    """Of one picture, in mm.

    Attributes:
        absolute: Mean |Z - truth|, Eq. (3).
        signed: Mean of Z - truth.
        percentile_95: Of |Z - truth|.
        inner: As `absolute`, for the inner 80 % of width and height.
        fill: Share of pixels that have depth, of those that see the surface.
    """

    absolute: float
    signed: float
    percentile_95: float
    inner: float
    fill: float


class Flatness(NamedTuple):
    """Of one picture of a wall.

    Attributes:
        rmse: Root mean square distance from the best plane [mm], Eq. (4).
        subpixel: The same as disparity [px], as the maker's quality tool gives it.
        point: Mean over target points of |median error| in a circle [mm].
        normal: Mean over target points of the angle between found and true normal [deg].
    """

    rmse: float
    subpixel: float
    point: float
    normal: float


def errors(depth: Array, truth: Array) -> Errors:
    """Compare depth with truth [m], shape (H, W) each; NaN in truth: not to be judged."""
    rows, columns = (
        slice(round(0.5 * (1.0 - INNER) * size), round(0.5 * (1.0 + INNER) * size)) for size in depth.shape
    )
    accuracy = z_accuracy(depth, truth)
    inner = z_accuracy(depth[rows, columns], truth[rows, columns]).absolute
    seen = np.isfinite(truth)
    return Errors(
        1e3 * accuracy.absolute,
        1e3 * accuracy.signed,
        1e3 * accuracy.percentile_95,
        1e3 * inner,
        float(np.isfinite(depth[seen]).mean()),
    )


def flatness(depth: Array, truth: Array, camera: Pinhole, focal_baseline: float) -> Flatness:
    """Judge a wall.

    Args:
        depth: [m], shape (H, W).
        truth: Of the wall [m], shape (H, W).
        camera: Of the depth picture.
        focal_baseline: f B [px m].
    """
    rays = camera.directions(camera.pixel_grid())
    points = rays * depth[..., None]
    sparse = points[::2, ::2]
    plane = fit_plane(sparse)
    flat = plane.depth_along(rays[::2, ::2])
    ripple = focal_baseline / depth[::2, ::2] - focal_baseline / flat
    medians, angles = zip(*_points(points, rays, depth, truth), strict=True)
    return Flatness(
        1e3 * plane_rmse(sparse, plane),
        float(np.sqrt(np.nanmean(np.square(ripple)))),
        float(np.nanmean(medians)),
        float(np.nanmean(angles)),
    )


def _points(points: Array, rays: Array, depth: Array, truth: Array) -> list[tuple[float, float]]:
    """|Median error| [mm] and angle of the normal [deg] about each target point; NaN without depth."""
    height, width = depth.shape
    radius = round(CIRCLE * width / 848)
    v, u = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    inside = u**2 + v**2 <= radius**2
    found = []
    for down in _GRID:
        for across in _GRID:
            y, x = round(down * height), round(across * width)
            window = (slice(y - radius, y + radius + 1), slice(x - radius, x + radius + 1))
            error = (depth[window] - truth[window])[inside]
            try:
                normal = fit_plane(points[window][inside]).normal
                true = fit_plane((rays[window] * truth[window][..., None])[inside]).normal
            except DegeneratePlaneError:
                found.append((np.nan, np.nan))
                continue
            angle = np.rad2deg(np.arccos(np.clip(normal @ true, -1.0, 1.0)))
            found.append((1e3 * abs(float(np.nanmedian(error))), float(angle)))
    return found
