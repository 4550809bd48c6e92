"""Teichman, Miller and Thrun 2013 ("CLAMS"): a factor per cell of the image and bin of depth, Z' = m Z.

    m = sum(w g^2) / sum(w g z)    over the samples (raw z, true g) of one cell and bin

A bin starts as one sample with m = 1. Between the middles of two bins m is linear in z if both have 50
samples, else it is constant in the bin.

What is chosen here, as it is not published or was made for another sensor:

* Weights w = 1 / g^4, since the noise of stereo grows with Z^2 (published: w = 1).
* The published bin of 2 m is wide for a camera that works below 2 m; 0.25 m is the default here.
* Samples off by more than 30 % do not count.
* A bin that other cells filled but this one did not takes the factor of the cell's nearest bin with samples:
  some twenty poses leave holes that a map made by walking about does not (published: m = 1).
* The map absorbs what the factory's transform has wrong; the method itself fits no transform.

A bin that no view reached in any cell leaves depth as it is: the method does not extrapolate.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.views.views import CalibrationView, true_depth
from numpy.typing import NDArray

from bathbot_bringup.evaluation.depth.measures import Depth, positive

Array = NDArray[np.float64]

CELL_WIDTH, CELL_HEIGHT = 8, 6  # [px]
FINE_BIN = 0.25  # [m]
PUBLISHED_BIN = 2.0  # [m]
FARTHEST = 10.0  # [m], end of the last bin
ENOUGH = 50  # samples for a bin to take part in interpolation
GROSS = 0.3  # relative error of a sample that does not count


@dataclass(frozen=True, slots=True, eq=False)
class Clams:
    """Factors m and numbers of samples, shape (bins, rows, columns); `width` of a bin [m]."""

    T_colour_depth: Array
    width: float
    factors: Depth
    samples: NDArray[np.int64]

    def apply(self, depth: Depth) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        cell = _cells(depth.shape, self.factors.shape[1:])
        place, last = np.nan_to_num(depth) / np.float32(self.width), len(self.factors) - 1
        own = np.clip(place.astype(np.intp), 0, last)
        past = place - own - np.float32(0.5)
        other = np.clip(own + np.where(past < 0.0, -1, 1), 0, last)
        factors, trusted = self.factors.reshape(last + 1, -1), self.samples.reshape(last + 1, -1) >= ENOUGH
        here = factors[own, cell]
        share = np.where(trusted[own, cell] & trusted[other, cell], np.abs(past), np.float32(0.0))
        return positive(depth * (here + share * (factors[other, cell] - here)))


def fit_clams(views: Sequence[CalibrationView], unit: CameraUnit, width: float = FINE_BIN) -> Clams:
    """Fit the factors, with bins of a width [m]."""
    camera = unit.depth_camera
    rows, columns = -(-camera.height // CELL_HEIGHT), -(-camera.width // CELL_WIDTH)
    bins = int(np.ceil(FARTHEST / width))
    cell = _cells((camera.height, camera.width), (rows, columns))
    middles = width * (np.arange(bins) + 0.5)
    above = np.repeat(middles**-2.0, rows * columns)
    below, samples = above.copy(), np.zeros(above.size, dtype=np.int64)
    for view in views:
        truth = true_depth(view, unit)
        usable = np.abs(view.depth / truth - 1.0) < GROSS
        raw, true = view.depth[usable].astype(float), truth[usable]
        index = np.minimum((raw / width).astype(np.intp), bins - 1) * (rows * columns) + cell[usable]
        above += view.frames * np.bincount(index, true**-2.0, above.size)
        below += view.frames * np.bincount(index, raw * true**-3.0, above.size)
        samples += view.frames * np.bincount(index, minlength=above.size)
    factors = _filled((above / below).reshape(bins, -1), samples.reshape(bins, -1) > 0)
    shape = (bins, rows, columns)
    return Clams(
        unit.T_colour_depth, width, factors.astype(np.float32).reshape(shape), samples.reshape(shape)
    )


def _filled(factors: Array, seen: NDArray[np.bool_]) -> Array:
    """Factors, shape (bins, cells), with the cell's nearest seen one in bins that only others saw."""
    filled, bins = factors.copy(), np.arange(len(factors))
    cells = np.flatnonzero(seen.any(axis=0))
    for index in np.flatnonzero(seen.any(axis=1)):
        steps = np.where(seen[:, cells], np.abs(bins - index)[:, None], len(bins))
        filled[index, cells] = factors[np.argmin(steps, axis=0), cells]
    return filled


def _cells(shape: tuple[int, ...], cells: tuple[int, ...]) -> NDArray[np.intp]:
    """Index of each pixel's cell, shape (H, W)."""
    v, u = np.ogrid[: shape[0], : shape[1]]
    return np.ravel_multi_index(np.broadcast_arrays(v // CELL_HEIGHT, u // CELL_WIDTH), cells)
