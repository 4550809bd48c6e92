"""What water, light and lenses do to a picture, each with its strength as an argument.

Training draws the strengths at random (`training/augment.py`), the evaluation sets them (`conditions.py`).
Pictures are RGB uint8, shape (h, w, 3); every function returns a new one of that shape.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]
Random = np.random.Generator
_DISPLAY = 2.2  # exponent from linear light to the values of a picture


def clipped(values: NDArray[np.floating]) -> Picture:
    """Values as the nearest 8-bit ones."""
    return np.clip(values, 0, 255).astype(np.uint8)


def veil(picture: Picture, density: float, unevenness: float, grey: float, random: Random) -> Picture:
    """Steam: a smooth cloud of light grey, between `density` and `density + unevenness` thick (0..1)."""
    height, width = picture.shape[:2]
    grid = random.random((int(random.integers(2, 6)), int(random.integers(2, 6)))).astype(np.float32)
    cloud = cv2.resize(grid, (width, height), interpolation=cv2.INTER_CUBIC)
    share = np.clip(density + cloud * unevenness, 0.0, 0.9)[..., None]
    return clipped(picture * (1.0 - share) + grey * share)


def drops(picture: Picture, count: int, largest: int, random: Random) -> Picture:
    """Drops on the lens: discs up to `largest` [px] that show a blurred picture, lit at the upper edge."""
    blurred = cv2.GaussianBlur(picture, (0, 0), 6)
    mask = np.zeros(picture.shape[:2], np.float32)
    for _ in range(count):
        centre = (int(random.integers(0, picture.shape[1])), int(random.integers(0, picture.shape[0])))
        cv2.circle(mask, centre, int(random.integers(2, max(largest, 3))), 1.0, -1, cv2.LINE_AA)
    light = np.clip(cv2.Sobel(cv2.GaussianBlur(mask, (0, 0), 1.5), cv2.CV_32F, 0, 1), 0, 1)
    return clipped(picture * (1 - mask[..., None]) + blurred * mask[..., None] + 40 * light[..., None])


def glints(picture: Picture, share: float, radius: float, light: float, random: Random) -> Picture:
    """Wet skin and tiles: a share of the pixels glints, `light` grey levels where the picture is white."""
    seeds = (random.random(picture.shape[:2], dtype=np.float32) < share).astype(np.float32)
    spots = cv2.GaussianBlur(seeds, (0, 0), radius)
    spots *= light / max(float(spots.max()), 1e-6)
    return clipped(picture + (spots * (picture.max(axis=2) / 255.0) ** 2)[..., None])


def unsharp(picture: Picture, sigma: float) -> Picture:
    """An unsharp lens: Gaussian blur of `sigma` [px]."""
    return cv2.GaussianBlur(picture, (0, 0), sigma)


def smear(picture: Picture, length: int, angle: float) -> Picture:
    """Motion blur over `length` [px] along a direction [rad]."""
    kernel = np.zeros((length, length), np.float32)
    reach = np.array([np.cos(angle), np.sin(angle)]) * (length - 1) / 2
    ends = np.round(np.array([-reach, reach]) + (length - 1) / 2).astype(int)
    cv2.line(kernel, tuple(map(int, ends[0])), tuple(map(int, ends[1])), 1.0)
    return cv2.filter2D(picture, -1, kernel / kernel.sum())


def exposed(picture: Picture, gain: float, noise: float, random: Random) -> Picture:
    """Another exposure: `gain` on the light, and noise of the sensor [grey levels]."""
    ramp = 255.0 * np.clip(gain * np.linspace(0.0, 1.0, 256) ** _DISPLAY, 0.0, 1.0) ** (1.0 / _DISPLAY)
    lit = cv2.LUT(picture, clipped(ramp))
    if not noise:
        return lit
    return clipped(lit + noise * random.standard_normal(picture.shape, dtype=np.float32))


def covered(picture: Picture, boxes: NDArray[np.floating], share: float, random: Random) -> Picture:
    """Cloth before each box (left, top, right, bottom), shape (n, 4) [px]: a share of its area is hidden.

    A piece of cloth has the shape of the box, one colour, folds and a weave.
    """
    result = picture.copy()
    for left, top, right, bottom in np.asarray(boxes, dtype=float).reshape(-1, 4):
        columns, rows = (max(round(side * np.sqrt(share)), 1) for side in (right - left, bottom - top))
        column = max(round(random.uniform(left, right - columns)), 0)
        row = max(round(random.uniform(top, bottom - rows)), 0)
        place = result[row : row + rows, column : column + columns]
        place[:] = cloth(place.shape[0], place.shape[1], random)
    return result


def cloth(rows: int, columns: int, random: Random) -> Picture:
    """A piece of cloth [px]: one colour, shaded by folds along a random direction, with a weave."""
    row, column = np.mgrid[0:rows, 0:columns].astype(np.float32)
    angle, length = random.uniform(0, np.pi), random.uniform(8, 60)
    folds = np.sin(
        (row * np.sin(angle) + column * np.cos(angle)) * (2 * np.pi / length) + random.uniform(0, 6)
    )
    shade = 1.0 + 0.15 * folds + 0.04 * random.standard_normal((rows, columns), dtype=np.float32)
    return clipped(random.uniform(20, 235, 3) * shade[..., None])
