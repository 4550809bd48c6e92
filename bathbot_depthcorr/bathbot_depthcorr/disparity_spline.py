"""The default correction: smooth maps of scale and offset in disparity, and the sub-pixel ripple.

    d' = d (1 + s(u, v)) + o(u, v) + sum_k a_k sin(2 pi k d) + b_k cos(2 pi k d),    d = f B / Z

Stereo noise and its errors are constant in disparity, not in depth, so that few coefficients describe
all distances and what lies beyond the views extrapolates sanely. Applied, this is one rational function
per pixel, Z' = Z / ((1 + s) + (o + ripple) Z / (f B)): exactly the identity at zero, and monotone in Z.
"""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_depthcorr.bspline_surface import SplineGrid
from bathbot_depthcorr.correction_model import CameraUnit, Correction, Depth
from bathbot_depthcorr.disparity_kernel import correct_disparity

RIPPLE_ORDERS = (1, 2)
_PER_METRE = np.float32(10_000.0)
_FARTHEST = 6.0  # [m], end of the ripple's table
_LARGEST_BEND = 0.5  # of the slope of d'(d): keeps the correction monotone


def ripple_terms(disparity: ArrayLike) -> NDArray[np.float64]:
    """Sines and cosines of the ripple, shape (..., 4), at disparities [px], shape (...)."""
    phase = 2.0 * np.pi * np.asarray(disparity)
    return np.stack([wave(order * phase) for order in RIPPLE_ORDERS for wave in (np.sin, np.cos)], axis=-1)


def tame(ripple: ArrayLike) -> NDArray[np.float64]:
    """Shrink ripple amplitudes [px], shape (4,), where they would make d'(d) fall."""
    ripple = np.asarray(ripple, dtype=float)
    orders = np.repeat(RIPPLE_ORDERS, 2)
    bend = 2.0 * np.pi * float(np.sum(orders * np.abs(ripple)))
    return ripple * min(1.0, _LARGEST_BEND / max(bend, 1e-12))


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
        focal_baseline = unit.focal_baseline
        self._scale = (1.0 + self._surface(self.scale)).astype(np.float32)
        self._offset = (self._surface(self.offset) / focal_baseline).astype(np.float32)
        self._table = _ripple_table(self.ripple, focal_baseline)

    def apply(self, depth: Depth, out: Depth | None = None) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        depth = self.check_shape(depth)
        out = np.empty_like(depth) if out is None else out
        correct_disparity(depth, self._scale, self._offset, self._table, _PER_METRE, out)
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

    def _surface(self, coefficients: NDArray) -> NDArray:
        rows, columns = coefficients.shape
        grid = SplineGrid(self.depth_camera.width, self.depth_camera.height, columns, rows)
        return grid.full(coefficients)


def _ripple_table(ripple: NDArray, focal_baseline: float) -> NDArray[np.float32]:
    depth = np.maximum(np.arange(int(_FARTHEST * _PER_METRE) + 2) / float(_PER_METRE), 0.1)
    return (ripple_terms(focal_baseline / depth) @ ripple / focal_baseline).astype(np.float32)
