"""The camera model of Eq. (5), with the lens distortion of a colour stream where there is one."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from bathbot_depthcorr.errors import DepthcorrError

Array = NDArray[np.float64]


class InvalidIntrinsicsError(DepthcorrError):
    """Numbers that describe no camera."""


@dataclass(frozen=True, slots=True)
class Pinhole:
    """Intrinsics of a camera, all in pixels; pixel (0, 0) is a centre.

    Attributes:
        distortion: OpenCV's (k1, k2, p1, p2, k3); empty for a rectified stream.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Refuse numbers that describe no camera."""
        sound = self.width > 0 and self.height > 0 and self.fx > 0.0 and self.fy > 0.0
        if not (sound and np.isfinite([self.fx, self.fy, self.cx, self.cy, *self.distortion]).all()):
            raise InvalidIntrinsicsError(
                f"intrinsics {self.width}x{self.height}, fx {self.fx}, fy {self.fy} describe no camera; "
                "is camera_info published by the camera driver?"
            )

    @property
    def matrix(self) -> Array:
        """Intrinsic matrix K of Eq. (5), shape (3, 3) [px]."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def coefficients(self) -> Array:
        """Distortion in OpenCV's order, shape (5,); zeros for a rectified stream."""
        return np.array(self.distortion or (0.0,) * 5)

    def scaled(self, width: int, height: int) -> "Pinhole":
        """The same camera read out at another size [px]; shapes of pixels may change."""
        x, y = width / self.width, height / self.height
        return Pinhole(
            width, height, self.fx * x, self.fy * y,
            (self.cx + 0.5) * x - 0.5, (self.cy + 0.5) * y - 0.5, self.distortion,
        )  # fmt: skip

    def directions(self, pixels: ArrayLike) -> Array:
        """Rays (x/z, y/z, 1) through pixels (u, v), shape (..., 2) -> (..., 3), distortion removed."""
        pixels = np.asarray(pixels, dtype=float)
        if not self.distortion:
            x, y = (pixels[..., 0] - self.cx) / self.fx, (pixels[..., 1] - self.cy) / self.fy
            return np.stack([x, y, np.ones_like(x)], axis=-1)
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 1e-12)
        plain = cv2.undistortPointsIter(
            pixels.reshape(-1, 1, 2), self.matrix, self.coefficients, None, None, criteria
        ).reshape(pixels.shape)
        return np.concatenate([plain, np.ones((*pixels.shape[:-1], 1))], axis=-1)

    def deproject(self, pixels: ArrayLike, depth: ArrayLike) -> Array:
        """Lift pixels (u, v), shape (..., 2), at depth [m], shape (...), by Eq. (5).

        Returns points in the camera frame [m], shape (..., 3); NaN where depth is NaN.
        """
        return self.directions(pixels) * np.asarray(depth, dtype=float)[..., None]

    def project(self, points: ArrayLike) -> Array:
        """Pixels (u, v), shape (..., 2), of points in the camera frame [m], shape (..., 3).

        NaN for points that are not in front of the camera.
        """
        points = np.asarray(points, dtype=float)
        depth = np.where(points[..., 2] > 0.0, points[..., 2], np.nan)
        plain = points[..., :2] / depth[..., None]
        if self.distortion:
            plain = self._distort(plain)
        return plain * (self.fx, self.fy) + (self.cx, self.cy)

    def _distort(self, plain: Array) -> Array:
        """Apply Brown-Conrady distortion to normalised coordinates, shape (..., 2)."""
        k1, k2, p1, p2, k3 = self.coefficients[:5]
        x, y = plain[..., 0], plain[..., 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        return np.stack([
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ], axis=-1)  # fmt: skip

    def pixel_grid(self) -> Array:
        """All pixels (u, v), shape (height, width, 2)."""
        return np.stack(np.meshgrid(np.arange(self.width), np.arange(self.height)), axis=-1).astype(float)
