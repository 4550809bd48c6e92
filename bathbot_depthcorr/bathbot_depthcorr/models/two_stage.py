"""The paper's correction: f_i flattens each pixel, f_g puts the flat wall where it truly is (Fig. 4).

    Z' = f_g(f_i(u, v, Z)),    f_i = a_0 + a_1 Z + a_2 Z^2 per cell,    f_g = c_0 + c_1 Z + c_2 Z^2

Outside the distances of the views the polynomials continue with slope one, and where one would fall with
Z it is drawn back to the identity, so that the correction is monotone.
"""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_depthcorr.geometry.camera_unit import CameraUnit
from bathbot_depthcorr.models.correction_model import Correction, Depth
from bathbot_depthcorr.models.disparity_kernel import correct_polynomial

_LEAST_SLOPE = 0.2


def make_monotone(coefficients: ArrayLike, near: float, far: float) -> NDArray[np.float64]:
    """Draw quadratics, shape (..., 3), lowest first, to the identity until they rise on [near, far] [m]."""
    coefficients = np.array(coefficients, dtype=float)
    slopes = [coefficients[..., 1] + 2.0 * coefficients[..., 2] * z for z in (near, far)]
    least = np.minimum(*slopes)
    share = np.where(least < _LEAST_SLOPE, (1.0 - _LEAST_SLOPE) / np.maximum(1.0 - least, 1e-9), 1.0)
    identity = np.array([0.0, 1.0, 0.0])
    return identity + (coefficients - identity) * share[..., None]


class TwoStage(Correction):
    """Polynomials per cell, then one for all; made by `two_stage_fit.fit_two_stage`."""

    model = "two_stage"

    def __init__(
        self,
        unit: CameraUnit,
        local: NDArray,
        overall: ArrayLike,
        span: tuple[float, float],
        noise: float,
    ) -> None:
        """Build the maps of the live correction.

        Args:
            unit: The camera.
            local: Coefficients of f_i on a coarse grid, lowest first, shape (h, w, 3).
            overall: Coefficients of f_g, lowest first, shape (3,).
            span: Least and greatest raw depth of the views [m].
            noise: Standard deviation of one pixel's disparity in one frame [px].
        """
        super().__init__(unit)
        self.span, self.noise = (float(span[0]), float(span[1])), float(noise)
        self.local = make_monotone(local, *self.span).astype(np.float32)
        self.overall = make_monotone(overall, *self.span)
        size = (self.depth_camera.width, self.depth_camera.height)
        self._local = np.ascontiguousarray(cv2.resize(self.local, size, interpolation=cv2.INTER_LINEAR))

    def apply(self, depth: Depth, out: Depth | None = None) -> Depth:
        """Correct depth [m], shape (H, W), NaN = none."""
        depth, out = self.check_shape(depth), self.output(out)
        near, far = np.float32(self.span)
        correct_polynomial(depth, self._local, self.overall.astype(np.float32), near, far, out)
        return out

    def sigma(self, depth: Depth) -> Depth:
        """Noise of one frame [m], which grows with the square of depth; the maps' own doubt is not known."""
        return np.square(self.check_shape(depth)) * np.float32(self.noise / self.unit.focal_baseline)

    def arrays(self) -> dict[str, NDArray]:
        """Coefficients of both stages, the span of the views and the noise."""
        return {
            "local": self.local, "overall": self.overall,
            "span": np.array(self.span), "noise": np.float64(self.noise),
        }  # fmt: skip

    @classmethod
    def from_arrays(cls, unit: CameraUnit, arrays: dict[str, NDArray]) -> "TwoStage":
        """Build the correction from what `arrays` gave."""
        local, overall, span, noise = (arrays[name] for name in ("local", "overall", "span", "noise"))
        if (
            local.ndim != 3
            or overall.shape != (3,)
            or not all(map(np.all, map(np.isfinite, (local, overall, span))))
        ):
            raise ValueError(f"coefficients of shape {local.shape} and {overall.shape}")
        return cls(unit, local, overall, (float(span[0]), float(span[1])), float(noise))

    @classmethod
    def drawn(cls, unit: CameraUnit, rng: np.random.Generator) -> "TwoStage":
        """Draw coefficients of a usual size, every part of the model in use."""
        cells = (unit.depth_camera.height // 8, unit.depth_camera.width // 8, 3)
        local = np.array([0.0, 1.0, 0.0]) + rng.normal(0.0, 0.005, cells)
        return cls(unit, local, (0.001, 0.99, 0.005), (0.4, 2.0), 0.07)
