"""Augmentations that leave boxes where they are: light, colour, noise, blur, steam, cover.

Those of section 2.1.1.1 are named as there; steam, droplets and wet highlights are ours, for
the bathroom. Each takes an RGB uint8 picture, shape (h, w, 3), and a random generator, and
returns a new picture of that shape.
"""

from collections.abc import Callable

import cv2
import numpy as np

from bathbot_perception.evaluation import effects
from bathbot_perception.evaluation.effects import Picture, Random, clipped


def hsv(picture: Picture, random: Random) -> Picture:
    """HSV transformation: turn the hue, scale saturation and value."""
    hue, saturation, value = cv2.split(cv2.cvtColor(picture, cv2.COLOR_RGB2HSV))
    ramp = np.arange(256, dtype=np.float32)
    hue = cv2.LUT(hue, ((ramp + random.uniform(-6, 6)) % 180).astype(np.uint8))
    saturation = cv2.LUT(saturation, clipped(ramp * random.uniform(0.55, 1.5)))
    value = cv2.LUT(value, clipped(ramp * random.uniform(0.55, 1.4)))
    return cv2.cvtColor(cv2.merge([hue, saturation, value]), cv2.COLOR_HSV2RGB)


def brightness(picture: Picture, random: Random) -> Picture:
    """Random brightness: a gamma curve and a shift."""
    ramp = np.linspace(0, 1, 256) ** np.exp(random.uniform(-0.7, 0.7)) * 255 + random.uniform(-20, 20)
    return cv2.LUT(picture, clipped(ramp))


def exposure(picture: Picture, random: Random) -> Picture:
    """Exposure: a sixth to four times the light, clipped, with the noise of the sensor."""
    return effects.exposed(
        picture, np.exp(random.uniform(np.log(0.15), np.log(4))), random.uniform(0, 4), random
    )


def contrast(picture: Picture, random: Random) -> Picture:
    """Random contrast about the mean."""
    mean = float(picture.mean())
    return cv2.LUT(picture, clipped((np.arange(256) - mean) * random.uniform(0.5, 1.5) + mean))


def white_balance(picture: Picture, random: Random) -> Picture:
    """The colour of the light: a gain for every channel."""
    gains = np.exp(random.uniform(-0.15, 0.15, 3))
    return cv2.LUT(picture, clipped(np.arange(256)[:, None, None] * gains).reshape(256, 1, 3))


def gaussian_noise(picture: Picture, random: Random) -> Picture:
    """Gaussian noise, a few grey levels."""
    noise = random.standard_normal(picture.shape, dtype=np.float32) * random.uniform(2, 14)
    return clipped(picture + noise)


def salt_and_pepper(picture: Picture, random: Random) -> Picture:
    """Salt-and-pepper noise: some pixels white, some black."""
    chance = random.random(picture.shape[:2], dtype=np.float32)
    rate = random.uniform(0.002, 0.02)
    result = picture.copy()
    result[chance < rate] = 0
    result[chance > 1 - rate] = 255
    return result


def random_pixels(picture: Picture, random: Random) -> Picture:
    """Random pixels: some take a random colour."""
    mask = random.random(picture.shape[:2], dtype=np.float32) < random.uniform(0.002, 0.02)
    result = picture.copy()
    result[mask] = random.integers(0, 256, (int(mask.sum()), 3), dtype=np.uint8)
    return result


def pixel_zeroing(picture: Picture, random: Random) -> Picture:
    """Random pixel zeroing."""
    result = picture.copy()
    result[random.random(picture.shape[:2], dtype=np.float32) < random.uniform(0.005, 0.04)] = 0
    return result


def gaussian_blur(picture: Picture, random: Random) -> Picture:
    """Gaussian blur, an unsharp lens: up to 0.7 % of the longer side."""
    return effects.unsharp(picture, max(max(picture.shape) * random.uniform(0.0008, 0.007), 0.4))


def motion_blur(picture: Picture, random: Random) -> Picture:
    """Motion blur along a random direction, up to 2.8 % of the longer side."""
    length = max(round(max(picture.shape) * random.uniform(0.004, 0.028)), 3)
    return effects.smear(picture, length, random.uniform(0, np.pi))


def adaptive_histogram_equalisation(picture: Picture, random: Random) -> Picture:
    """Adaptive histogram equalisation of the lightness (CLAHE)."""
    lightness, a, b = cv2.split(cv2.cvtColor(picture, cv2.COLOR_RGB2LAB))
    lightness = cv2.createCLAHE(random.uniform(1, 4), (8, 8)).apply(lightness)
    return cv2.cvtColor(cv2.merge([lightness, a, b]), cv2.COLOR_LAB2RGB)


def edge_enhancement(picture: Picture, random: Random) -> Picture:
    """Edge enhancement: an unsharp mask."""
    amount = random.uniform(0.3, 1.5)
    return cv2.addWeighted(picture, 1 + amount, cv2.GaussianBlur(picture, (0, 0), 1.5), -amount, 0)


def max_pooling(picture: Picture, random: Random) -> Picture:
    """Max pooling over 2x2 or 3x3 pixels, at the old size."""
    size = int(random.integers(2, 4))
    return cv2.dilate(picture, np.ones((size, size), np.uint8))


def average_pooling(picture: Picture, random: Random) -> Picture:
    """Average pooling: down by up to 2 and up again."""
    height, width = picture.shape[:2]
    factor = random.uniform(1.3, 2.2)
    small = cv2.resize(
        picture, (max(int(width / factor), 1), max(int(height / factor), 1)), interpolation=cv2.INTER_AREA
    )
    return cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR)


def occlusion(picture: Picture, random: Random) -> Picture:
    """Random rectangular occlusion: one to four patches, flat, or a piece of the same picture."""
    height, width = picture.shape[:2]
    result = picture.copy()
    for _ in range(int(random.integers(1, 5))):
        h, w = (int(side * random.uniform(0.04, 0.2)) + 1 for side in (height, width))
        row, column = int(random.integers(0, height - h)), int(random.integers(0, width - w))
        if random.random() < 0.5:
            result[row : row + h, column : column + w] = random.integers(0, 256, 3, dtype=np.uint8)
        else:
            other_row, other_column = int(random.integers(0, height - h)), int(random.integers(0, width - w))
            result[row : row + h, column : column + w] = picture[
                other_row : other_row + h, other_column : other_column + w
            ]
    return result


def steam(picture: Picture, random: Random) -> Picture:
    """Steam: a smooth cloud of light grey over the picture, and less contrast."""
    density, unevenness = random.uniform(0.0, 0.35), random.uniform(0.1, 0.5)
    return effects.veil(picture, density, unevenness, random.uniform(170, 245), random)


def droplets(picture: Picture, random: Random) -> Picture:
    """Drops on the lens: small discs that show a blurred picture, lit at the upper edge."""
    return effects.drops(picture, int(random.integers(4, 25)), 12, random)


def wet_highlights(picture: Picture, random: Random) -> Picture:
    """Wet skin and tiles: small glints where the picture is already light."""
    return effects.glints(picture, 0.01, random.uniform(0.8, 2.0), random.uniform(60, 200), random)


def cast_shadow(picture: Picture, random: Random) -> Picture:
    """A shadow with a soft straight edge."""
    height, width = picture.shape[:2]
    angle = random.uniform(0, 2 * np.pi)
    rows, columns = np.mgrid[0:height, 0:width].astype(np.float32)
    distance = (columns - random.uniform(0, width)) * np.cos(angle) + (
        rows - random.uniform(0, height)
    ) * np.sin(angle)
    shade = 1 - random.uniform(0.2, 0.6) / (1 + np.exp(-np.clip(distance / random.uniform(3, 30), -30, 30)))
    return clipped(picture * shade[..., None])


PHOTOMETRIC: tuple[tuple[Callable[[Picture, Random], Picture], float], ...] = (
    (hsv, 0.7),
    (brightness, 0.35),
    (exposure, 0.15),
    (contrast, 0.25),
    (white_balance, 0.3),
    (cast_shadow, 0.08),
    (occlusion, 0.12),
    (steam, 0.12),
    (wet_highlights, 0.05),
    (droplets, 0.05),
    (edge_enhancement, 0.05),
    (adaptive_histogram_equalisation, 0.05),
    (max_pooling, 0.03),
    (average_pooling, 0.08),
    (gaussian_blur, 0.12),
    (motion_blur, 0.1),
    (gaussian_noise, 0.10),
    (salt_and_pepper, 0.03),
    (random_pixels, 0.03),
    (pixel_zeroing, 0.03),
)
"""Every augmentation and the chance that a picture gets it, in the order they are applied."""


def photometric(picture: Picture, random: Random) -> Picture:
    """Apply each augmentation with its own chance."""
    for augmentation, chance in PHOTOMETRIC:
        if random.random() < chance:
            picture = augmentation(picture, random)
    return picture
