"""A correction that gives each imager its own map: the right one is read where the match was found.

    d' = d (1 + s) + l(u, v) - r(u - d, v) + ripple(d),    d = f B / Z

Rectification leaves an error in each of the two imagers. The right imager's moves over the image as the
distance changes, which scale and offset per pixel can follow in part only.
"""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_depthcorr.geometry.bspline_surface import SplineGrid, row_step
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Correction, Depth
from bathbot_depthcorr.models.disparity_kernel import correct_two_imagers
from bathbot_depthcorr.models.ripple import tame

_STEEPEST = 0.3  # slope of the right map along u: keeps the correction monotone


def tame_map(coefficients: ArrayLike, width: int) -> NDArray[np.float64]:
    """Flatten a map, coefficients [px] of shape (rows, columns), where it is steep enough to bend d'(d) back.

    Args:
        coefficients: Of a B-spline; differences of neighbours over a knot's width bound its slope.
        width: Of the image [px].
    """
    coefficients = np.asarray(coefficients, dtype=float)
    steepest = np.abs(np.diff(coefficients, axis=1)).max() * (coefficients.shape[1] - 3) / width
    return coefficients * min(1.0, _STEEPEST / max(steepest, 1e-12))


class TwoImager(Correction):
    """One scale, one map per imager; made by `two_imager_fit.fit_two_imager`."""

    model = "two_imager"

    def __init__(
        self,
        unit: CameraUnit,
        scale: float,
        left: NDArray,
        right: NDArray,
        ripple: ArrayLike,
        noise: float,
        variances: NDArray,
    ) -> None:
        """Build the tables of the live correction.

        Args:
            unit: The camera.
            scale: s.
            left: Coefficients of the left imager's map [px], shape (rows, columns).
            right: Of the right imager's.
            ripple: Amplitudes a_1, b_1, a_2, b_2 [px].
            noise: Standard deviation of one pixel's disparity in one frame [px].
            variances: Of the corrected disparity [px^2] at evenly spaced disparities from 0 to a tenth of the
                image's width, on a coarse grid over the image, shape (levels, h, w).
        """
        super().__init__(unit)
        self.scale, self.noise = float(scale), float(noise)
        self.left, self.right = np.asarray(left, dtype=float), tame_map(right, unit.depth_camera.width)
        self.ripple = tame(ripple)
        self.variances = np.asarray(variances, dtype=np.float32)
        self._step = row_step(unit.depth_camera.height)
        self._left, self._right = self._rows(self.left), self._rows(self.right)

    def apply(self, depth: Depth, out: Depth | None = None) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        depth, out = self.check_shape(depth), self.output(out)
        correct_two_imagers(
            depth, np.float32(1.0 + self.scale), self._left, self._right, self._step,
            np.float32(self.unit.focal_baseline), self.ripple.astype(np.float32), out,
        )  # fmt: skip
        return out

    def sigma(self, depth: Depth) -> Depth:
        """Noise and doubt of the maps at corrected depth Z [m]: Z^2/fB sqrt(noise^2 + b' C b)."""
        depth = self.check_shape(depth)
        size = (self.depth_camera.width, self.depth_camera.height)
        levels = np.stack(
            [cv2.resize(plane, size, interpolation=cv2.INTER_LINEAR) for plane in self.variances]
        )
        place = self.unit.focal_baseline / depth / widest_disparity(size[0]) * (len(levels) - 1)
        place = np.clip(np.nan_to_num(place), 0.0, len(levels) - 1.001)
        below = place.astype(np.intp)[None]
        share = place - below[0]
        low, high = (np.take_along_axis(levels, below + k, axis=0)[0] for k in (0, 1))
        variance = np.float32(self.noise**2) + low + share * (high - low)
        return (np.square(depth) / self.unit.focal_baseline * np.sqrt(variance)).astype(np.float32)

    def arrays(self) -> dict[str, NDArray]:
        """Coefficients, noise and the variances of the maps."""
        return {
            "scale": np.float64(self.scale), "left": self.left, "right": self.right, "ripple": self.ripple,
            "noise": np.float64(self.noise), "variances": self.variances,
        }  # fmt: skip

    @classmethod
    def from_arrays(cls, unit: CameraUnit, arrays: dict[str, NDArray]) -> "TwoImager":
        """Build the correction from what `arrays` gave."""
        names = ("scale", "left", "right", "ripple", "noise", "variances")
        scale, left, right, ripple, noise, variances = (arrays[name] for name in names)
        if ripple.shape != (4,) or not all(np.isfinite(arrays[name]).all() for name in names):
            raise ValueError(f"ripple of shape {ripple.shape} or a value that is not finite")
        return cls(unit, float(scale), left, right, ripple, float(noise), variances)

    @classmethod
    def drawn(cls, unit: CameraUnit, rng: np.random.Generator) -> "TwoImager":
        """Draw coefficients of a usual size, every part of the model in use."""
        left, right = rng.normal(0.3, 0.1, (2, 14, 24))
        return cls(unit, 0.01, left, right, rng.normal(0.0, 0.01, 4), 0.07, np.full((4, 9, 16), 1e-4))

    def _rows(self, coefficients: NDArray) -> NDArray[np.float32]:
        rows, columns = coefficients.shape
        grid = SplineGrid(self.depth_camera.width, self.depth_camera.height, columns, rows)
        return grid.sparse_rows(coefficients, self._step)


def widest_disparity(width: int) -> float:
    """Disparity [px] that variances are kept for: a tenth of the image's width, the matcher's search."""
    return 0.1 * width
