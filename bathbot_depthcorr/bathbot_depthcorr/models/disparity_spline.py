"""The default correction: smooth maps of scale and offset in disparity, and the sub-pixel ripple.

    d' = d (1 + s(u, v)) + o(u, v) + sum_k a_k sin(2 pi k d) + b_k cos(2 pi k d),    d = f B / Z

Stereo noise and its errors are constant in disparity, not in depth, so that few coefficients describe
all distances and what lies beyond the views extrapolates sanely. Applied, this is one rational function
per pixel, Z' = Z / ((1 + s) + (o + ripple) Z / (f B)): exactly the identity at zero, and monotone in Z.
"""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_depthcorr.geometry.bspline_surface import SplineGrid, row_step
from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Correction, Depth
from bathbot_depthcorr.models.disparity_kernel import correct_disparity
from bathbot_depthcorr.models.ripple import tame


class DisparitySpline(Correction):
    """Scale and offset of disparity as tensor B-splines; made by `disparity_fit.fit_disparity_spline`."""

    model = "disparity_spline"

    def __init__(
        self,
        unit: CameraUnit,
        scale: NDArray,
        offset: NDArray,
        ripple: ArrayLike,
        noise: float,
        variances: NDArray,
    ) -> None:
        """Build the tables of the live correction.

        Args:
            unit: The camera.
            scale: Coefficients of s, shape (rows, columns).
            offset: Coefficients of o [px], shape (rows, columns).
            ripple: Amplitudes a_1, b_1, a_2, b_2 [px].
            noise: Standard deviation of one pixel's disparity in one frame [px].
            variances: Var(o), Cov(o, s) and Var(s) on a coarse grid over the image, shape (3, h, w).
        """
        super().__init__(unit)
        self.scale, self.offset = np.asarray(scale, dtype=float), np.asarray(offset, dtype=float)
        self.ripple, self.noise = tame(ripple), float(noise)
        self.variances = np.asarray(variances, dtype=np.float32)
        self._step = row_step(unit.depth_camera.height)
        self._scale = np.float32(1.0) + self._rows(self.scale)
        self._offset = self._rows(self.offset)

    def apply(self, depth: Depth, out: Depth | None = None) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        depth, out = self.check_shape(depth), self.output(out)
        focal_baseline = np.float32(self.unit.focal_baseline)
        ripple = self.ripple.astype(np.float32)
        correct_disparity(depth, self._scale, self._offset, self._step, focal_baseline, ripple, out)
        return out

    def sigma(self, depth: Depth) -> Depth:
        """Noise and doubt of the maps at corrected depth Z [m]: Z^2/fB sqrt(noise^2 + b' C b)."""
        depth = self.check_shape(depth)
        size = (self.depth_camera.width, self.depth_camera.height)
        offset, mixed, scale = (
            cv2.resize(plane, size, interpolation=cv2.INTER_LINEAR) for plane in self.variances
        )
        disparity = np.float32(self.unit.focal_baseline) / depth
        variance = np.float32(self.noise**2) + offset + disparity * (2.0 * mixed + disparity * scale)
        return np.square(depth) / np.float32(self.unit.focal_baseline) * np.sqrt(np.maximum(variance, 0.0))

    def arrays(self) -> dict[str, NDArray]:
        """Coefficients, noise and the variances of the maps."""
        return {
            "scale": self.scale, "offset": self.offset, "ripple": self.ripple,
            "noise": np.float64(self.noise), "variances": self.variances,
        }  # fmt: skip

    @classmethod
    def from_arrays(cls, unit: CameraUnit, arrays: dict[str, NDArray]) -> "DisparitySpline":
        """Build the correction from what `arrays` gave."""
        values = [arrays[name] for name in ("scale", "offset", "ripple", "noise", "variances")]
        if values[2].shape != (4,) or not all(np.isfinite(value).all() for value in values):
            raise ValueError(f"ripple of shape {values[2].shape} or a value that is not finite")
        return cls(unit, values[0], values[1], values[2], float(values[3]), values[4])

    @classmethod
    def drawn(cls, unit: CameraUnit, rng: np.random.Generator) -> "DisparitySpline":
        """Draw coefficients of a usual size, every part of the model in use."""
        scale, offset = rng.normal(0.01, 0.003, (4, 6)), rng.normal(0.3, 0.1, (14, 24))
        return cls(unit, scale, offset, rng.normal(0.0, 0.01, 4), 0.07, np.full((3, 9, 16), 1e-4))

    def _rows(self, coefficients: NDArray) -> NDArray[np.float32]:
        rows, columns = coefficients.shape
        grid = SplineGrid(self.depth_camera.width, self.depth_camera.height, columns, rows)
        return grid.sparse_rows(coefficients, self._step)
