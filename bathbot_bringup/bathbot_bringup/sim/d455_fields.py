"""Residual rectification of the two imagers, and noise as wide as a matching window."""

import cv2
import numpy as np
from numpy.typing import NDArray

from bathbot_bringup.sim.d455_unit import Preset

NATIVE_WIDTH = 1280  # [px] that the presets count in
FIELD_WIDTH = 60.0  # [px] standard deviation of the smooth field's bumps, native
FROZEN_WIDTH = 3.0  # [px] of the stream
TEMPORAL_WIDTH = 2.0  # [px] of the stream


def imager_field(rng: np.random.Generator, preset: Preset, width: int, height: int) -> NDArray[np.float32]:
    """Disparity error an imager adds to each of its pixels [px of the stream], shape (height, width).

    A tilt, a cubic radial term x r^2 and a smooth random field.
    """
    u = np.linspace(-1.0, 1.0, width)[None, :]
    v = np.linspace(-height / width, height / width, height)[:, None]
    slope = preset.tilt * rng.normal(size=2)
    radial = preset.radial * rng.uniform(0.75, 1.25) * rng.choice([-1.0, 1.0])
    sigma = FIELD_WIDTH * width / NATIVE_WIDTH / 4.0
    bumps = soft_noise(rng, (height // 4 + 1, width // 4 + 1), sigma)
    bumps = cv2.resize(bumps, (width, height), interpolation=cv2.INTER_CUBIC)
    field = slope[0] * u + slope[1] * v + radial * u * (u**2 + v**2) / (1.0 + (height / width) ** 2)
    return ((field + preset.smooth * bumps) * width / NATIVE_WIDTH).astype(np.float32)


def soft_noise(rng: np.random.Generator, shape: tuple[int, int], sigma: float) -> NDArray[np.float32]:
    """Gaussian noise of unit variance, as smooth as a Gaussian window of a width [px]."""
    white = rng.standard_normal(shape, dtype=np.float32)
    # a normalised Gaussian window leaves 1 / (2 sqrt(pi) sigma) of white noise's spread
    return cv2.GaussianBlur(white, (0, 0), sigma) * np.float32(2.0 * np.sqrt(np.pi) * sigma)
