"""What a look at one corrected frame tells of the camera: how full, how flat, how quiet it is.

Flatness and noise are judged in the middle third of the image, on a thousand points: a wall there
is what the paper's Eq. (4) and Intel's depth quality tool measure; anything else is said to be no plane.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.pinhole import Pinhole
from bathbot_depthcorr.geometry.plane import DegeneratePlaneError, fit_plane
from bathbot_depthcorr.geometry.quality import fill_rate, plane_rmse, temporal_noise, wall_accuracy
from bathbot_depthcorr.models.correction_model import Correction

Depth = NDArray[np.float32]

LEAST_FILL = 0.01  # below this share of pixels a frame counts as empty
_POINTS_ACROSS = 40
_FLAT = 0.01  # of the distance: a surface that deviates more is no plane
_TAILS = (0.5, 99.5)  # [%] of the distances that count, as in Intel's tool


class FrameQuality(NamedTuple):
    """NaN stands for what is not known.

    Attributes:
        fill: Share of pixels with depth, 0..1.
        sigma: 1-sigma of the model at the median depth [m].
        plane_rmse: Of the middle of the image about its own plane, Eq. (4) [m].
        is_plane: Whether the middle is flat enough for that to mean anything.
        accuracy: Signed Z-accuracy against a wall at a known distance, 0.01 = 1 %.
        noise: Standard deviation between two frames [m].
    """

    fill: float
    sigma: float
    plane_rmse: float
    is_plane: bool
    accuracy: float
    noise: float


UNKNOWN = "unknown"


def quality_values(quality: FrameQuality | None, wall_distance: float) -> dict[str, str]:
    """Words and numbers for a diagnostic; a quality that is not known says so."""
    if quality is None:
        return dict.fromkeys(("fill", "sigma_mm", "plane_rmse_mm", "noise_mm", "z_accuracy"), UNKNOWN)
    rmse, accuracy = _mm(quality.plane_rmse), UNKNOWN
    if wall_distance > 0.0:
        accuracy = f"{100.0 * quality.accuracy:+.2f} %" if quality.is_plane else "no plane"
    return {
        "fill": f"{quality.fill:.3f}", "sigma_mm": _mm(quality.sigma), "noise_mm": _mm(quality.noise),
        "plane_rmse_mm": rmse if quality.is_plane or rmse == UNKNOWN else f"no plane ({rmse})",
        "z_accuracy": accuracy,
    }  # fmt: skip


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f}" if np.isfinite(metres) else UNKNOWN


class Centre:
    """The points in the middle third of a camera's image that stand for it."""

    def __init__(self, camera: Pinhole) -> None:
        """Choose the pixels."""
        step = max(camera.width // 3 // _POINTS_ACROSS, 1)
        self.window = (
            slice(camera.height // 3, 2 * camera.height // 3 + 1, step),
            slice(camera.width // 3, 2 * camera.width // 3 + 1, step),
        )
        self._directions = camera.directions(camera.pixel_grid()[self.window])

    def sample(self, depth: Depth) -> Depth:
        """Copy the chosen pixels of a frame [m], shape (H, W)."""
        return depth[self.window].copy()

    def points(self, sample: Depth) -> NDArray[np.float64]:
        """Points of a sample in the camera frame [m], shape (..., 3)."""
        return self._directions * sample[..., None]


def _near_the_median(depth: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which depths, shape (N,), belong to the main surface; far outliers would turn the first fit around."""
    if depth.size == 0:
        return np.zeros(0, bool)
    away = np.abs(depth - np.median(depth))
    return away <= 5.0 * max(float(np.median(away)), 1e-3)


def judge_frame(
    correction: Correction, depth: Depth, centre: Centre, before: Depth | None, wall_distance: float = 0.0
) -> FrameQuality:
    """Judge one corrected frame.

    Args:
        correction: That made it.
        depth: Corrected depth [m], shape (H, W), NaN = none.
        centre: Of the same camera.
        before: Sample of the frame before, for the noise; None if there was none.
        wall_distance: True depth on the axis of the wall that the camera sees [m]; 0 if unknown.
    """
    fill, nan = fill_rate(depth[::2, ::2]), float("nan")
    sigma = float(np.nanmedian(correction.sigma(depth)[::4, ::4])) if fill >= LEAST_FILL else nan
    sample = centre.sample(depth)
    comparable = before is not None and before.shape == sample.shape  # not after a change of size
    noise = temporal_noise(sample, before) if comparable else nan
    points = centre.points(sample)
    points = points[np.isfinite(points).all(axis=-1)]
    try:
        plane = fit_plane(points[_near_the_median(points[:, 2])], robust=True)
    except DegeneratePlaneError:
        return FrameQuality(fill, sigma, nan, False, nan, noise)
    distance = plane.distance(points)
    low, high = np.percentile(distance, _TAILS)
    rmse = plane_rmse(points[(distance >= low) & (distance <= high)], plane)
    is_plane = rmse <= _FLAT * float(np.median(points[:, 2]))
    accuracy = wall_accuracy(points, plane, wall_distance) if is_plane and wall_distance > 0.0 else nan
    return FrameQuality(fill, sigma, rmse, is_plane, accuracy, noise)
