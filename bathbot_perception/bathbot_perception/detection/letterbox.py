"""Fitting a picture into the detector's input without distorting it, and back."""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
GREY = 114
"""Value of the padding, as in training."""
STRIDE = 32
"""Sides of the input are multiples of this."""


class Letterbox(NamedTuple):
    """Map from picture pixels to input pixels: scale, then move by (left, top) [px].

    Pixel coordinates are continuous with (0, 0) at the upper left corner of both.
    """

    scale_u: float
    scale_v: float
    left: int
    top: int
    width: int
    height: int

    def to_input(self, boxes: Array) -> Array:
        """Boxes (left, top, right, bottom), shape (..., 4), from the picture to the input."""
        return boxes * self._scale + self._offset

    def to_picture(self, boxes: Array) -> Array:
        """Boxes, shape (..., 4), from the input to the picture."""
        return (boxes - self._offset) / self._scale

    @property
    def _scale(self) -> Array:
        return np.array([self.scale_u, self.scale_v, self.scale_u, self.scale_v])

    @property
    def _offset(self) -> Array:
        return np.array([self.left, self.top, self.left, self.top], dtype=float)


def fit_input(picture: tuple[int, int], long_side: int, fixed: tuple[int, int] | None = None) -> Letterbox:
    """Choose where a picture goes.

    Args:
        picture: Height and width of the picture [px].
        long_side: Longer side of the input [px], a multiple of 32. The shorter side becomes the
            least multiple of 32 that holds the picture.
        fixed: Height and width of the input [px], for a model that takes one shape only.
    """
    height, width = picture
    bounds = fixed or (long_side, long_side)
    scale = min(bounds[0] / height, bounds[1] / width)
    rows = min(max(round(height * scale), 1), bounds[0])
    columns = min(max(round(width * scale), 1), bounds[1])
    full = fixed or (math.ceil(rows / STRIDE) * STRIDE, math.ceil(columns / STRIDE) * STRIDE)
    top, left = (full[0] - rows) // 2, (full[1] - columns) // 2
    return Letterbox(columns / width, rows / height, left, top, full[1], full[0])


class Letterboxing:
    """Fits pictures of one size into the input, each in the memory of the one before.

    Fresh memory for every picture would take as long as all the arithmetic.
    """

    def __init__(self, picture: tuple[int, int], fit: Letterbox) -> None:
        """Lay the padding out.

        Args:
            picture: Height and width [px].
            fit: Where pictures go, from `fit_input`.
        """
        self.picture, self.fit = picture, fit
        height, width = picture
        rows, columns = round(height * fit.scale_v), round(width * fit.scale_u)
        self._interpolation = _interpolation(columns / width)
        self._small = np.empty((rows, columns, 3), np.uint8)
        self._pixels = np.full((1, 3, fit.height, fit.width), GREY, np.uint8)
        self._inside = list(self._pixels[0, :, fit.top : fit.top + rows, fit.left : fit.left + columns])

    def __call__(self, rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Pixels, shape (1, 3, fit.height, fit.width), of a picture of shape (h, w, 3)."""
        size = self._small.shape[1::-1]
        cv2.resize(rgb, size, dst=self._small, interpolation=self._interpolation)
        cv2.split(self._small, self._inside)
        return self._pixels


class Scaling:
    """Turns pixels 0..255 into the values 0..1 of a float network, each in the memory of the one before."""

    def __init__(self) -> None:
        """Begin without memory."""
        self._values = np.zeros((0, 0, 0, 0), np.float32)

    def __call__(self, pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Values of pixels, shape (1, 3, h, w)."""
        if self._values.shape != pixels.shape:
            self._values = np.empty(pixels.shape, np.float32)
        for values, colour in zip(self._values[0], pixels[0], strict=True):  # one fits a core's cache
            np.copyto(values, colour)
            values *= np.float32(1.0 / 255.0)
        return self._values


def letterbox(picture: NDArray[np.uint8], fit: Letterbox) -> NDArray[np.float32]:
    """The input of a float network: RGB in [0, 1], shape (1, 3, fit.height, fit.width).

    Args:
        picture: RGB, shape (h, w, 3).
        fit: Where it goes, from `fit_input`.
    """
    return Scaling()(Letterboxing(picture.shape[:2], fit)(picture))


def _interpolation(scale: float) -> int:
    """Means over areas where two neighbours would miss pixels; they take seven times as long."""
    return cv2.INTER_AREA if scale < 0.5 else cv2.INTER_LINEAR
