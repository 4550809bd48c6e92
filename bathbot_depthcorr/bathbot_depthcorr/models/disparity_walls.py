"""Calibration views as the disparity models see them: block means of disparity along known rays."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Correction
from bathbot_depthcorr.models.ripple import ripple_terms
from bathbot_depthcorr.views.views import CalibrationView, block_means, block_size, true_disparity

Array = NDArray[np.float64]


class Wall(NamedTuple):
    """One view as rows of a fit, N usable blocks.

    Attributes:
        blocks: Indices of the blocks, row by row over the image, shape (N,).
        pixels: Mean pixel (u, v) of each block, shape (N, 2).
        directions: Depth rays, shape (N, 3).
        disparity: Mean disparity [px], shape (N,).
        ripple: Means of the ripple's terms, shape (N, 4).
        plane: Inverse form m of the wall in the colour frame [1/m], shape (3,).
        information: Inverse covariance of m [m^2], shape (3, 3).
    """

    blocks: NDArray[np.intp]
    pixels: Array
    directions: Array
    disparity: Array
    ripple: Array
    plane: Array
    information: Array


def wall_rows(view: CalibrationView, unit: CameraUnit) -> Wall:
    """Average a view over blocks.

    Sines and cosines are averaged pixel by pixel: on a tilted wall a block spans a good part of a period.
    """
    camera, size = unit.depth_camera, block_size(unit.depth_camera)
    valid = view.depth > 0.0
    disparity = unit.focal_baseline / np.where(valid, view.depth, 1.0)
    means = block_means(disparity, valid, size)
    used = np.flatnonzero(np.isfinite(means.ravel()))

    def mean(values: NDArray) -> Array:
        return block_means(values, valid, size).ravel()[used]

    u, v = np.meshgrid(np.arange(camera.width, dtype=float), np.arange(camera.height, dtype=float))
    pixels = np.stack([mean(u), mean(v)], axis=-1)
    waves = ripple_terms(disparity)
    return Wall(
        used,
        pixels,
        camera.directions(pixels),
        means.ravel()[used],
        np.stack([mean(waves[..., k]) for k in range(waves.shape[-1])], axis=-1),
        view.plane.inverse_form,
        np.linalg.inv(view.covariance + np.eye(3) * 1e-12),
    )


def wall_noise(correction: Correction, views: Sequence[CalibrationView]) -> float:
    """Standard deviation of one pixel's disparity in one frame [px], from what a correction leaves.

    A constant error of a whole view is taken out: it comes from the view's plane, not from the pixels.
    """
    unit, variances = correction.unit, []
    sparse = (slice(None, None, 3), slice(None, None, 3))
    rays = unit.depth_camera.directions(unit.depth_camera.pixel_grid()[sparse])
    for view in views:
        left = unit.focal_baseline / correction.apply(view.depth)[sparse] - true_disparity(view, unit, rays)
        left = left[np.isfinite(left)]
        frozen = 1.4826 * np.median(np.abs(left - np.median(left)))
        variances.append(
            frozen**2 + (1.0 - 1.0 / view.frames) * (unit.focal_baseline * view.temporal_noise) ** 2
        )
    return float(np.sqrt(np.median(variances)))
